#include "engine/lab/model_selection/choose.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace springdrive::model_selection {

namespace {

bool is_cheaper(const Candidate &a, const Candidate &b) {
    return a.cost.min_ns < (1.0 - kSameCost) * b.cost.min_ns;
}

/// The cheapest that meets on its own. The fullest always meets, being the reference.
std::size_t cheapest_meeting(const ModelAxis &axis, const scene::ModelTolerance &tolerance) {
    const auto &all = axis.candidates;
    const auto share = [&](std::size_t i) { return share_of_tolerance(all[i].error, tolerance); };
    std::size_t cheapest = all.size() - 1;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (share(i) <= 1.0 && all[i].cost.min_ns < all[cheapest].cost.min_ns) {
            cheapest = i;
        }
    }
    std::size_t best = cheapest;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (!is_cheaper(all[cheapest], all[i]) && share(i) < share(best)) {
            best = i;
        }
    }
    return best;
}

/// Clearly cheaper candidates that are worth a trial, the most expensive first: that one in any
/// case, and those that meet on their own.
std::vector<std::size_t> cheaper_ones(const ModelAxis &axis, std::size_t than,
                                      const scene::ModelTolerance &tolerance) {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < axis.candidates.size(); ++i) {
        if (is_cheaper(axis.candidates[i], axis.candidates[than])) {
            found.push_back(i);
        }
    }
    std::ranges::sort(found, [&](std::size_t a, std::size_t b) {
        return axis.candidates[a].cost.min_ns > axis.candidates[b].cost.min_ns;
    });
    if (!found.empty()) {
        const auto misses = [&](std::size_t i) {
            return !meets(axis.candidates[i].error, tolerance);
        };
        found.erase(std::remove_if(found.begin() + 1, found.end(), misses), found.end());
    }
    return found;
}

/// The cheapest of those with a smaller error.
std::size_t next_better(const ModelAxis &axis, std::size_t than,
                        const scene::ModelTolerance &tolerance) {
    const double share = share_of_tolerance(axis.candidates[than].error, tolerance);
    std::size_t next = axis.candidates.size() - 1;
    for (std::size_t i = 0; i < axis.candidates.size(); ++i) {
        const Candidate &candidate = axis.candidates[i];
        if (share_of_tolerance(candidate.error, tolerance) < share &&
            candidate.cost.min_ns < axis.candidates[next].cost.min_ns) {
            next = i;
        }
    }
    return next;
}

class Chooser {
public:
    Chooser(std::vector<ModelAxis> axes, const scene::ModelTolerance &tolerance,
            const std::function<ModelError(const Picks &)> &error_of)
        : chosen_{std::move(axes), {}}, tolerance_(tolerance), error_of_(error_of) {
        for (const ModelAxis &axis : chosen_.axes) {
            picks_.push_back(cheapest_meeting(axis, tolerance));
        }
    }

    ChosenModel choose() {
        chosen_.error = error_of_(picks_);
        while (!meets(chosen_.error, tolerance_) && step_up()) {
            chosen_.error = error_of_(picks_);
        }
        while (step_down()) {
        }
        for (std::size_t i = 0; i < picks_.size(); ++i) {
            chosen_.axes[i].chosen = picks_[i];
        }
        return std::move(chosen_);
    }

private:
    /// False if all are already at their fullest.
    bool step_up() {
        std::optional<std::size_t> worst;
        double worst_share = 0.0;
        for (std::size_t i = 0; i < picks_.size(); ++i) {
            const std::vector<Candidate> &candidates = chosen_.axes[i].candidates;
            const double share = share_of_tolerance(candidates[picks_[i]].error, tolerance_);
            if (picks_[i] + 1 != candidates.size() && (!worst || share > worst_share)) {
                worst = i;
                worst_share = share;
            }
        }
        if (worst) {
            picks_[*worst] = next_better(chosen_.axes[*worst], picks_[*worst], tolerance_);
        }
        return worst.has_value();
    }

    /// True if a cheaper candidate also meets, and was taken.
    bool step_down() {
        for (std::size_t i = 0; i < picks_.size(); ++i) {
            ModelAxis &axis = chosen_.axes[i];
            axis.cheaper.clear();
            for (const std::size_t candidate : cheaper_ones(axis, picks_[i], tolerance_)) {
                Picks picks = picks_;
                picks[i] = candidate;
                const ModelError error = error_of_(picks);
                if (meets(error, tolerance_)) {
                    picks_ = picks;
                    chosen_.error = error;
                    return true;
                }
                axis.cheaper.push_back({candidate, error});
            }
        }
        return false;
    }

    ChosenModel chosen_;
    scene::ModelTolerance tolerance_;
    const std::function<ModelError(const Picks &)> &error_of_;
    Picks picks_;
};

} // namespace

ChosenModel choose_model(std::vector<ModelAxis> axes, const scene::ModelTolerance &tolerance,
                         const std::function<ModelError(const Picks &)> &error_of) {
    return Chooser(std::move(axes), tolerance, error_of).choose();
}

} // namespace springdrive::model_selection

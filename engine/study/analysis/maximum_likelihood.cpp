#include "engine/study/analysis/maximum_likelihood.h"

#include "base/assertions.h"
#include "base/bisection.h"
#include "engine/study/analysis/scoring.h"

#include <algorithm>
#include <cmath>

namespace springdrive::study {

namespace {

/// One end of the profile's interval of a coordinate.
struct ProfileEnd {
    double at = 0.0;
    bool is_open = false;
};

/// Follows the profile from the maximum to an end of the range.
class Profile {
public:
    Profile(std::span<const LevelCount> counts, const ScoredModel &model, Eigen::Index coordinate,
            double confidence)
        : counts_(counts), model_(model), coordinate_(coordinate),
          best_(scored_best(counts, model)) {
        held_[static_cast<std::size_t>(coordinate)] = true;
        // χ² with one degree of freedom is the square of a normal value.
        const double z = core_argument(Shape::cumulative_normal, 0.5 + 0.5 * confidence);
        lowest_log_likelihood_ = best_.log_likelihood - 0.5 * z * z;
    }

    [[nodiscard]] ProfileEnd end(double range_end) const {
        const double from = best_.at[coordinate_];
        if (from == range_end || holds(range_end)) {
            return {range_end, true};
        }
        constexpr int kHalvings = 45;
        return {bisect({from, range_end}, kHalvings, [this](double value) { return holds(value); })
                    .holds_at,
                false};
    }

private:
    [[nodiscard]] bool holds(double value) const {
        // The profile may have several maxima, so it is tried from the fit and from a grid.
        Coordinates start = best_.at;
        start[coordinate_] = value;
        return scored_from(counts_, model_, start, held_).log_likelihood >=
                   lowest_log_likelihood_ ||
               scored_best(counts_, model_, held_, start).log_likelihood >= lowest_log_likelihood_;
    }

    std::span<const LevelCount> counts_;
    ScoredModel model_;
    Eigen::Index coordinate_;
    Scored best_;
    std::array<bool, 4> held_{};
    double lowest_log_likelihood_ = 0.0;
};

template <typename ToUnit>
ProfileInterval interval_of(std::span<const LevelCount> counts, const ScoredModel &model,
                            Eigen::Index coordinate, double confidence, const ToUnit &to_unit) {
    SPRINGDRIVE_ASSERT(confidence > 0.0 && confidence < 1.0);
    const Profile profile(counts, model, coordinate, confidence);
    const ProfileEnd low = profile.end(model.lowest[coordinate]);
    const ProfileEnd high = profile.end(model.highest[coordinate]);
    return {to_unit(low.at), to_unit(high.at), low.is_open, high.is_open};
}

} // namespace

LikelihoodFit maximum_likelihood(std::span<const LevelCount> counts, const FunctionPriors &priors) {
    SPRINGDRIVE_ASSERT(!counts.empty());
    const ScoredModel model = model_at(priors, core_at_threshold(priors.family.shape));
    const Scored best = scored_best(counts, model);
    LikelihoodFit fit;
    fit.function = function_at(model, best.at);
    fit.log_likelihood = best.log_likelihood;
    for (std::size_t i = 0; i < fit.is_at_end.size(); ++i) {
        const auto j = static_cast<Eigen::Index>(i);
        const bool is_free = model.lowest[j] < model.highest[j];
        fit.free_parameters += is_free ? 1 : 0;
        fit.is_at_end[i] =
            is_free && (best.at[j] == model.lowest[j] || best.at[j] == model.highest[j]);
    }
    return fit;
}

ProfileInterval profile_interval(std::span<const LevelCount> counts, const FunctionPriors &priors,
                                 FunctionParameter parameter, double confidence) {
    if (parameter == FunctionParameter::threshold) {
        return profile_interval_at(counts, priors, core_at_threshold(priors.family.shape),
                                   confidence);
    }
    const ScoredModel model = model_at(priors, core_at_threshold(priors.family.shape));
    return interval_of(
        counts, model, static_cast<Eigen::Index>(parameter), confidence,
        [&](double at) { return parameter == FunctionParameter::slope ? std::exp(at) : at; });
}

ProfileInterval profile_interval_at(std::span<const LevelCount> counts,
                                    const FunctionPriors &priors, double core, double confidence) {
    const ScoredModel model = model_at(priors, core);
    return interval_of(counts, model, 0, confidence,
                       [&](double at) { return level_from(priors.family.scale, at); });
}

} // namespace springdrive::study

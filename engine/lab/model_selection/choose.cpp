#include "engine/lab/model_selection/choose.h"

#include "base/cancellation.h"
#include "engine/lab/model_selection/contact_shapes.h"
#include "engine/lab/model_selection/model_run.h"
#include "engine/lab/rig/scenario/scenarios.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

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

constexpr double kFinestStep_s = 32e-6;

ModelSetting setting_of(const ModelQuestion &question, const contact::HapticSurface &surface) {
    const scene::Scene &scene = *question.scene;
    rig::Exploration how;
    how.planar = scene.planar;
    const rig::ScenarioSetting of_question{question.device, question.tuning,
                                           device::default_pose_rad(), question.period_s,
                                           question.delay_periods};
    return {rig::exploration_scenario(of_question,
                                      rig::placed(surface, scene.lower_m, scene.upper_m), how),
            control::global_alpha_bound(question.device)};
}

/// A scene's models: the candidates, and the error and cost of each combination.
class SceneModels {
public:
    SceneModels(const ModelQuestion &question, const ModelProgress &progress)
        : question_(question), progress_(progress) {
        report_progress("surfaces");
        shapes_ = contact_shapes_of(*question.scene);
        for (const ContactShape &shape : shapes_) {
            stop_if_given_up();
            surfaces_.push_back(haptic_surface_of(*question.scene, shape));
        }
        for (int steps = 1;; steps *= 2) {
            steps_.push_back(steps);
            if (question.period_s / steps <= kFinestStep_s) {
                break;
            }
        }
        joints_ = question.scene->planar ? std::vector<int>{2, 3} : std::vector<int>{3};
        setting_.emplace(setting_of(question, surfaces_.back()));
        trials_ = 1 + simulated::kPlantModels.size() + steps_.size() + joints_.size() +
                  shapes_.size() + kMotionControllers.size() + 3 * kModelAspects;
        report_progress("fullest model");
        fullest_ = run_model(*setting_, model(fullest_picks()), surfaces_.back());
    }

    [[nodiscard]] Picks fullest_picks() const {
        return {simulated::kPlantModels.size() - 1, steps_.size() - 1, joints_.size() - 1,
                shapes_.size() - 1, kMotionControllers.size() - 1};
    }

    [[nodiscard]] Model model(const Picks &picks) const {
        return {simulated::kPlantModels[picks[0]], steps_[picks[1]], joints_[picks[2]] == 2,
                shapes_[picks[3]], kMotionControllers[picks[4]]};
    }

    ModelError error(const Picks &picks) {
        if (picks == fullest_picks()) {
            return {};
        }
        report_progress("together");
        return error_of(picks);
    }

    [[nodiscard]] std::vector<ModelAxis> measured_axes() {
        std::vector<ModelAxis> axes;
        axes.push_back(
            axis(ModelAspect::plant, "plant", simulated::kPlantModels.size(),
                 [](std::size_t i) { return std::string(simulated::kPlantModels[i].name); }));
        axes.push_back(axis(ModelAspect::steps, "steps", steps_.size(),
                            [&](std::size_t i) { return std::to_string(steps_[i]); }));
        axes.push_back(axis(ModelAspect::joints, "joints", joints_.size(),
                            [&](std::size_t i) { return std::to_string(joints_[i]); }));
        axes.push_back(axis(ModelAspect::surface, "surface", shapes_.size(),
                            [&](std::size_t i) { return name_of(shapes_[i]); }));
        axes.push_back(axis(ModelAspect::controller, "controller", kMotionControllers.size(),
                            [](std::size_t i) { return std::string(kMotionControllers[i].name); }));
        return axes;
    }

    /// Of everything that a model runs in a tick.
    [[nodiscard]] double cost_ns(const Picks &picks) const {
        return costs(ModelAspect::plant, {picks})[0].min_ns +
               costs(ModelAspect::surface, {picks})[0].min_ns +
               costs(ModelAspect::controller, {picks})[0].min_ns;
    }

    [[nodiscard]] bool touches() const { return fullest_.touches(); }

private:
    void report_progress(const std::string &what) {
        if (progress_) {
            const double share = static_cast<double>(reports_) / static_cast<double>(trials_);
            progress_(what, std::min(share, 1.0));
        }
        ++reports_;
    }

    [[nodiscard]] ModelError error_of(const Picks &picks) const {
        const ModelRun run = run_model(*setting_, model(picks), surfaces_[picks[3]]);
        return model_error(run, fullest_, question_.period_s,
                           question_.scene->tolerance.bandwidth_hz);
    }

    /// Of the part that the aspect decides, with each of the picks.
    [[nodiscard]] std::vector<Cost> costs(ModelAspect aspect,
                                          const std::vector<Picks> &candidates) const {
        std::vector<Model> models;
        std::vector<const contact::HapticSurface *> surfaces;
        std::vector<MotionController> controllers;
        for (const Picks &picks : candidates) {
            models.push_back(model(picks));
            surfaces.push_back(&surfaces_[picks[3]]);
            controllers.push_back(models.back().controller);
        }
        switch (aspect) {
        case ModelAspect::surface:
            return contact_costs(surfaces, fullest_);
        case ModelAspect::controller:
            return control_costs(*setting_, controllers, fullest_);
        case ModelAspect::plant:
        case ModelAspect::steps:
        case ModelAspect::joints:
            break;
        }
        return plant_costs(*setting_, models, fullest_);
    }

    template <typename Name>
    ModelAxis axis(ModelAspect aspect, const std::string &axis_name, std::size_t size,
                   const Name &name) {
        ModelAxis result;
        result.name = axis_name;
        std::vector<Picks> candidates(size, fullest_picks());
        for (std::size_t i = 0; i < size; ++i) {
            candidates[i][static_cast<std::size_t>(aspect)] = i;
        }
        report_progress("what " + axis_name + " costs");
        const std::vector<Cost> cost = costs(aspect, candidates);
        for (std::size_t i = 0; i < size; ++i) {
            report_progress(axis_name + " " + name(i));
            const bool is_fullest = i + 1 == size;
            result.candidates.push_back(
                {name(i), cost[i], is_fullest ? ModelError{} : error_of(candidates[i])});
        }
        return result;
    }

    const ModelQuestion &question_;
    const ModelProgress &progress_;
    std::vector<ContactShape> shapes_;
    std::vector<contact::HapticSurface> surfaces_;
    std::vector<int> steps_;
    std::vector<int> joints_;
    std::optional<ModelSetting> setting_;
    ModelRun fullest_;
    std::size_t trials_ = 1;
    std::size_t reports_ = 0;
};

std::vector<std::string> warnings_about(const ModelSelection &choice, const SceneModels &models) {
    std::vector<std::string> warnings;
    if (!models.touches()) {
        warnings.emplace_back("the hand path for the comparison did not touch the scene: the "
                              "choice is valid for free space only");
    }
    const ModelAxis &joints = choice.axis(ModelAspect::joints);
    if (joints.candidates.size() > 1 && joints.chosen != 0) {
        warnings.emplace_back("the scene is declared planar, but its surface pushes sideways: "
                              "all three joints are simulated");
    }
    return warnings;
}

} // namespace

ChosenModel choose_model(std::vector<ModelAxis> axes, const scene::ModelTolerance &tolerance,
                         const std::function<ModelError(const Picks &)> &error_of) {
    return Chooser(std::move(axes), tolerance, error_of).choose();
}

ModelSelection choose_scene_model(const ModelQuestion &question, const ModelProgress &progress) {
    SceneModels models(question, progress);
    ModelSelection choice;
    choice.tolerance = question.scene->tolerance;
    const ChosenModel chosen =
        choose_model(models.measured_axes(), choice.tolerance,
                     [&](const Picks &picks) { return models.error(picks); });
    choice.axes = chosen.axes;
    choice.error = chosen.error;
    Picks picks;
    for (const ModelAxis &axis : choice.axes) {
        picks.push_back(axis.chosen);
    }
    choice.cost_ns = models.cost_ns(picks);
    choice.fullest_cost_ns = models.cost_ns(models.fullest_picks());
    choice.warnings = warnings_about(choice, models);
    return choice;
}

} // namespace springdrive::model_selection

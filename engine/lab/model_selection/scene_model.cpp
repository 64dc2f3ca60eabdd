#include "engine/lab/model_selection/scene_model.h"

#include "base/cancellation.h"
#include "engine/lab/model_selection/choose.h"
#include "engine/lab/model_selection/contact_shapes.h"
#include "engine/lab/model_selection/model_cost.h"
#include "engine/lab/rig/scenario/scenarios.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

namespace springdrive::model_selection {

namespace {

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

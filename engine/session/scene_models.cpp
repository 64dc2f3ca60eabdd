#include "engine/session/scene_models.h"

#include "base/assertions.h"

#include <cmath>
#include <exception>
#include <utility>

namespace springdrive::session {

namespace {

std::string text_of(const std::string &what, double share) {
    return what + ", " + std::to_string(std::lround(100.0 * share)) + " %";
}

/// A scene without its visual data: all that a choice needs, and small enough to be copied.
scene::Scene without_looks(const scene::Scene &scene) {
    scene::Scene bare;
    bare.file = scene.file;
    bare.surface = scene.surface;
    bare.flat_surface = scene.flat_surface;
    bare.shapes = scene.shapes;
    bare.lower_m = scene.lower_m;
    bare.upper_m = scene.upper_m;
    bare.metres_per_unit = scene.metres_per_unit;
    bare.in_metres = scene.in_metres;
    bare.planar = scene.planar;
    bare.tolerance = scene.tolerance;
    return bare;
}

model_selection::ModelQuestion question_on(const scene::Scene &scene, const ModelGround &ground,
                                           const control::Tuning &tuning) {
    return {&scene, ground.device, tuning, ground.period_s, ground.delay_periods};
}

const model_selection::ModelChooser &chooser_of(const ModelOptions &wanted) {
    SPRINGDRIVE_ASSERT(wanted.chooser != nullptr);
    return *wanted.chooser;
}

/// Uses the surface set by option, or else that of the choice.
void take_surface(LoadedScene &loaded, const ModelOptions &wanted) {
    std::optional<model_selection::ContactShape> shape;
    if (loaded.choice) {
        shape = model_selection::model_of(*loaded.choice).shape;
    }
    if (wanted.surface) {
        shape = wanted.surface;
    }
    if (shape && *shape != model_selection::ContactShape{}) {
        loaded.surface = chooser_of(wanted).surface_of(loaded.scene, *shape);
    }
}

bool uses(const model_selection::MotionController &controller, const control::Tuning &tuning) {
    return tuning.map == controller.map && tuning.alpha_mode == controller.alpha_mode;
}

/// Restores the motion controller of the start, because a model chooses its own.
control::Tuning with_controller_of(const control::Tuning &started_with, control::Tuning tuning) {
    tuning.map = started_with.map;
    tuning.alpha_mode = started_with.alpha_mode;
    return tuning;
}

} // namespace

void ModelMeasurement::begin(std::shared_ptr<const model_selection::ModelChooser> chooser,
                             const model_selection::ModelQuestion &question,
                             const model_selection::ModelMemory &memory) {
    discard();
    error_.clear();
    measuring_.start([chooser = std::move(chooser), question, memory,
                      scene = without_looks(*question.scene)](BackgroundTalk &talk) {
        model_selection::ModelQuestion own = question;
        own.scene = &scene;
        return chooser->measured(own, memory, [&talk](const std::string &what, double share) {
            talk.report(what, share);
        });
    });
}

std::string ModelMeasurement::progress() const {
    return text_of(measuring_.what(), measuring_.share());
}

std::optional<model_selection::ModelSelection> ModelMeasurement::take() {
    try {
        return measuring_.take();
    } catch (const std::exception &error) {
        error_ = error.what();
        return std::nullopt;
    }
}

void SceneModels::set_ground(const ModelGround &ground) {
    ground_ = ground;
    measurement_.discard();
}

model_selection::ModelQuestion SceneModels::question(const scene::Scene &scene,
                                                     const control::Tuning &tuning) const {
    return question_on(scene, ground_, with_controller_of(started_with_, tuning));
}

SceneLoader::Finish SceneModels::finish(const control::Tuning &tuning) const {
    return [wanted = wanted_, ground = ground_, tuning = with_controller_of(started_with_, tuning)](
               LoadedScene &loaded, scene::LoadProgress &progress, BackgroundTalk &talk) {
        if (wanted.automatic) {
            progress.begin(scene::LoadProgress::Stage::measuring, true);
            loaded.choice =
                chooser_of(wanted).known(question_on(loaded.scene, ground, tuning), ground.memory,
                                         [&](const std::string &what, double share) {
                                             talk.report(what, share);
                                             progress.advance_to(share);
                                         });
        }
        take_surface(loaded, wanted);
    };
}

void SceneModels::note_shown(const LoadedScene &scene) {
    measurement_.discard();
    choice_ = scene.choice;
}

void SceneModels::apply_to(const LoadedScene &scene,
                           const std::optional<model_selection::ModelSelection> &before,
                           bool may_hold_base, simulated::SimulationOptions &simulation,
                           control::Tuning &tuning) const {
    if (scene.choice) {
        const model_selection::Model model = model_selection::model_of(*scene.choice);
        model_selection::apply(model, simulation);
        simulation.planar = model.planar && may_hold_base;
        const bool is_tuned =
            before && !uses(model_selection::model_of(*before).controller, tuning);
        if (wanted_.takes_controller && !is_tuned) {
            tuning = model_selection::with_controller(model.controller, tuning);
        }
    }
    if (wanted_.plant) {
        simulation.dynamics = wanted_.plant->dynamics;
        simulation.effects = wanted_.plant->effects;
    }
    simulation.longest_step_s = wanted_.longest_step_s.value_or(simulation.longest_step_s);
}

void SceneModels::measure(const scene::Scene &scene, const control::Tuning &tuning, bool fresh) {
    const model_selection::ModelQuestion asked = question(scene, tuning);
    std::optional<model_selection::ModelSelection> remembered;
    if (!fresh) {
        remembered = chooser_of(wanted_).stored(asked, ground_.memory);
    }
    if (remembered) {
        choice_ = std::move(remembered);
    } else {
        measurement_.begin(wanted_.chooser, asked, ground_.memory);
    }
}

void SceneModels::update() {
    if (std::optional<model_selection::ModelSelection> choice = measurement_.take()) {
        choice_ = std::move(choice);
    }
}

} // namespace springdrive::session

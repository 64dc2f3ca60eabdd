#include "engine/session/loaded_scene.h"

#include "base/assertions.h"
#include "base/cancellation.h"
#include "base/sha256.h"
#include "engine/contact/mesh/mesh_report.h"
#include "engine/scene/gltf.h"
#include "engine/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <iterator>
#include <utility>

namespace springdrive::session {

std::unique_ptr<LoadedScene> load_scene(const std::filesystem::path &file,
                                        const device::Workspace &workspace,
                                        scene::LoadProgress &progress,
                                        const std::string &gltf_scene) {
    const StopScope given_up(&progress.is_cancelled());
    scene::Scene scene = scene::load_gltf(file, workspace, &progress, gltf_scene);
    progress.begin(scene::LoadProgress::Stage::preparing, false);
    contact::HapticSurface surface = scene::haptic_surface_of(scene);
    std::ranges::move(contact::warnings_about(surface.report(), scene.surface.materials),
                      std::back_inserter(scene.warnings));
    return std::make_unique<LoadedScene>(
        LoadedScene{std::move(scene), std::move(surface), sha256_of_file(file)});
}

void Scenes::request(const std::filesystem::path &file, const std::string &gltf_scene,
                     const Finish &finish) {
    if (is_loading()) {
        next_ = Request{file, gltf_scene, finish};
        loading_.ask_to_end();
        progress_->give_up();
        return;
    }
    error_.clear();
    progress_ = std::make_shared<scene::LoadProgress>();
    loading_.start([file, gltf_scene, finish, workspace = workspace_,
                    progress = progress_](BackgroundTalk &talk) {
        std::unique_ptr<LoadedScene> loaded = load_scene(file, workspace, *progress, gltf_scene);
        if (finish) {
            const StopScope given_up(&progress->is_cancelled());
            finish(*loaded, *progress, talk);
        }
        return loaded;
    });
}

const LoadedScene *Scenes::take_loaded() {
    std::unique_ptr<LoadedScene> loaded;
    try {
        loaded = loading_.take().value_or(nullptr);
    } catch (const std::exception &error) {
        error_ = error.what();
    }
    if (next_ && !is_loading()) {
        const Request next = *std::exchange(next_, std::nullopt);
        request(next.file, next.gltf_scene, next.finish);
    }
    if (!loaded) {
        return nullptr;
    }
    retired_.push_back(std::exchange(now_, std::move(loaded)));
    ++id_;
    return retired_.back().get();
}

void Scenes::note_in_use(std::uint32_t id) {
    if (id != id_) {
        return;
    }
    for (std::unique_ptr<LoadedScene> &scene : std::exchange(retired_, {})) {
        release_.let_go(std::move(scene));
    }
}

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

const model_selection::ModelChooser &chooser_of(const ModelOptions &requested) {
    SPRINGDRIVE_ASSERT(requested.chooser != nullptr);
    return *requested.chooser;
}

/// Uses the surface set by option, or else that of the choice.
void take_surface(LoadedScene &loaded, const ModelOptions &requested) {
    std::optional<model_selection::ContactShape> shape;
    if (loaded.choice) {
        shape = model_selection::model_of(*loaded.choice).shape;
    }
    if (requested.surface) {
        shape = requested.surface;
    }
    if (shape && *shape != model_selection::ContactShape{}) {
        loaded.surface = chooser_of(requested).surface_of(loaded.scene, *shape);
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

Scenes::Finish SceneModels::finish(const control::Tuning &tuning) const {
    return [requested = requested_, ground = ground_,
            tuning = with_controller_of(started_with_, tuning)](
               LoadedScene &loaded, scene::LoadProgress &progress, BackgroundTalk &talk) {
        if (requested.automatic) {
            progress.begin(scene::LoadProgress::Stage::measuring, true);
            loaded.choice = chooser_of(requested).known(question_on(loaded.scene, ground, tuning),
                                                        ground.memory,
                                                        [&](const std::string &what, double share) {
                                                            talk.report(what, share);
                                                            progress.advance_to(share);
                                                        });
        }
        take_surface(loaded, requested);
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
        if (requested_.takes_controller && !is_tuned) {
            tuning = model_selection::with_controller(model.controller, tuning);
        }
    }
    if (requested_.plant) {
        simulation.dynamics = requested_.plant->dynamics;
        simulation.effects = requested_.plant->effects;
    }
    simulation.longest_step_s = requested_.longest_step_s.value_or(simulation.longest_step_s);
}

void SceneModels::measure(const scene::Scene &scene, const control::Tuning &tuning, bool fresh) {
    const model_selection::ModelQuestion requested = question(scene, tuning);
    std::optional<model_selection::ModelSelection> remembered;
    if (!fresh) {
        remembered = chooser_of(requested_).stored(requested, ground_.memory);
    }
    if (remembered) {
        choice_ = std::move(remembered);
    } else {
        measurement_.begin(requested_.chooser, requested, ground_.memory);
    }
}

void SceneModels::update() {
    if (std::optional<model_selection::ModelSelection> choice = measurement_.take()) {
        choice_ = std::move(choice);
    }
}

} // namespace springdrive::session

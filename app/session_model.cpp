// The part of `Session` that chooses which model runs.
#include "app/session.h"
#include "engine/model_choice/contact_shapes.h"

#include <optional>
#include <utility>

namespace springdrive {

namespace {

ModelQuestion question_on(const Scene &scene, const DeviceDescription &device,
                          const SessionOptions &options) {
    return {&scene, device, options.tuning, servo_period_s(options.servo_hz),
            options.delay_periods};
}

/// As set by option, or else as chosen.
void take_surface(LoadedScene &loaded, const ModelOptions &wanted) {
    std::optional<ContactShape> shape;
    if (loaded.choice) {
        shape = model_of(*loaded.choice).shape;
    }
    if (wanted.surface) {
        shape = wanted.surface;
    }
    if (shape && *shape != ContactShape{}) {
        loaded.surface = haptic_surface_of(loaded.scene, *shape);
    }
}

bool uses(const MotionController &controller, const Tuning &tuning) {
    return tuning.map == controller.map && tuning.alpha_mode == controller.alpha_mode;
}

} // namespace

/// With the gains in force: a model is as good as those that it was measured with. The controller
/// is what a model chooses.
SessionOptions Session::options_now() const {
    SessionOptions now = options_;
    now.tuning = inputs_.tuning;
    now.tuning.map = options_.tuning.map;
    now.tuning.alpha_mode = options_.tuning.alpha_mode;
    return now;
}

/// For scenes that are loaded later.
SceneLoader::Finish Session::give_model() const {
    return [options = options_now(), device_text = device_text_,
            device = read_device_text(device_text_, options_.device_file)](
               LoadedScene &loaded, LoadProgress &progress, BackgroundTalk &talk) {
        if (options.model.automatic) {
            progress.begin(LoadProgress::Stage::measuring, true);
            loaded.choice = known_choice(question_on(loaded.scene, device, options), device_text,
                                         [&](const std::string &what, double share) {
                                             talk.tell(what, share);
                                             progress.advance_to(share);
                                         });
        }
        take_surface(loaded, options.model);
    };
}

void Session::request_scene(const std::filesystem::path &file) {
    loader_.request(file, give_model());
}

void Session::choose_models() {
    options_.model.automatic = true;
    request_scene(scene_->scene.file);
}

void Session::choose_first_model(const DeviceDescription &description) {
    if (options_.model.automatic) {
        scene_->choice = choice_with_progress(question_on(scene_->scene, description, options_),
                                              device_text_, false);
    }
    take_surface(*scene_, options_.model);
    take_model({});
}

/// Plant and law for the scene that is shown, from what was chosen for it and what is set. What
/// somebody tuned since the choice before, if one ran, stays.
void Session::take_model(const std::optional<ModelChoice> &before) {
    model_choice_ = scene_->choice;
    const ModelOptions &wanted = options_.model;
    if (model_choice_) {
        const Model model = model_of(*model_choice_);
        const bool may_hold_base = !device_ || simulation_.planar;
        apply(model, simulation_);
        simulation_.planar = model.planar && may_hold_base;
        const bool is_tuned =
            device_ && before && !uses(model_of(*before).controller, inputs_.tuning);
        if (wanted.takes_controller && !is_tuned) {
            inputs_.tuning = with_controller(model.controller, inputs_.tuning);
        }
    }
    if (wanted.plant) {
        simulation_.dynamics = wanted.plant->dynamics;
        simulation_.effects = wanted.plant->effects;
    }
    simulation_.longest_step_s = wanted.longest_step_s.value_or(simulation_.longest_step_s);
    if (device_ && model_choice_) {
        device_->simulate_as(simulation_);
    }
}

void Session::measure_model(bool fresh) {
    const ModelQuestion question = question_on(scene_->scene, device(), options_now());
    std::optional<ModelChoice> remembered;
    if (!fresh) {
        remembered = remembered_choice(question, device_text_);
    }
    if (remembered) {
        model_choice_ = std::move(remembered);
    } else {
        model_measurement_.begin(question, device_text_);
    }
}

} // namespace springdrive

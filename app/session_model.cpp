// The part of `Session` that chooses which model runs.
#include "app/session.h"
#include "engine/model_choice/contact_shapes.h"

#include <optional>
#include <utility>

namespace springdrive {

ModelQuestion Session::model_question(const DeviceDescription &description) const {
    return {&scene_->scene, description, options_.tuning, servo_period_s(options_.servo_hz),
            options_.delay_samples};
}

/// Before anything runs: afterwards neither the plant nor the first surface is exchanged.
void Session::choose_model(const DeviceDescription &description, SimulationOptions &simulation) {
    const ModelOptions &wanted = options_.model;
    std::optional<ContactShape> surface = wanted.surface;
    if (wanted.automatic) {
        model_choice_ = choice_with_progress(model_question(description), device_text_, false);
        model_scene_id_ = 1;
        const Model model = model_of(*model_choice_);
        apply(model, simulation);
        surface = surface.value_or(model.shape);
        if (wanted.takes_controller) {
            inputs_.tuning = with_controller(model.controller, inputs_.tuning);
        }
    }
    if (wanted.plant) {
        simulation.dynamics = wanted.plant->dynamics;
        simulation.effects = wanted.plant->effects;
    }
    simulation.longest_step_s = wanted.longest_step_s.value_or(simulation.longest_step_s);
    if (surface && *surface != ContactShape{}) {
        scene_->surface = haptic_surface_of(scene_->scene, *surface);
    }
}

void Session::measure_model(bool fresh) {
    const ModelQuestion question = model_question(device());
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

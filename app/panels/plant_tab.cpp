#include "app/panels/panels.h"
#include "app/widgets/widgets.h"
#include "base/error_text.h"

#include <algorithm>
#include <string>

namespace springdrive::app {

namespace {

void draw_rate(session::Session &session, PlantTabState &state) {
    double rate_hz = session.servo().rate_hz();
    ImGui::SetNextItemWidth(4.5F * ImGui::GetFontSize());
    if (ui::number_field("##rate", rate_hz, "%.0f") && rate_hz != session.servo().rate_hz()) {
        state.error = error_text_of([&] { session.set_servo_rate(rate_hz); });
    }
    ui::explain("rate of the servo, from the next tick on; a record goes on in its file");
    ImGui::SameLine();
    ui::text(kFaintInk, "Hz");
}

/// A delay that is being dragged is set once the slider is let go: each change lets the servo
/// pause, and its observers wait.
void draw_delay(session::Session &session, PlantTabState &state) {
    const double delay = session.device().device().delay_periods();
    state.delay_periods = state.dragging_delay ? state.delay_periods : delay;
    ImGui::SetNextItemWidth(9.0F * ImGui::GetFontSize());
    ui::slider_with_number("##delay", state.delay_periods, 0.0,
                           simulated::SimulationOptions::kMaxDelay, "delay %.2f periods");
    state.dragging_delay = ImGui::IsItemActive();
    if (ImGui::IsItemDeactivatedAfterEdit() && state.delay_periods != delay) {
        state.error = error_text_of([&] { session.set_delay(state.delay_periods); });
    }
    ui::explain("from reading the encoders to applying e_W: d, in periods of the servo");
}

/// Of a drawn device only: other devices have none of these.
bool needs_seed(const simulated::PlantEffect &effect) {
    return effect.on == &simulated::PlantEffects::motor_tolerances ||
           effect.on == &simulated::PlantEffects::commutator_phase ||
           effect.on == &simulated::PlantEffects::current_sensing;
}

void draw_effects(session::Session &session, PlantTabState &state) {
    const simulated::SimulationOptions &simulation = session.simulation();
    if (!ImGui::BeginTable("effects", 2)) {
        return;
    }
    for (const simulated::PlantEffect &effect : simulated::kPlantEffects) {
        ImGui::TableNextColumn();
        const bool has_none = needs_seed(effect) && simulation.device_seed == 0;
        const bool is_chosen = session.models().is_automatic();
        const ui::Disabled disabled(has_none || is_chosen || session.is_exchanging());
        std::string name(effect.name);
        std::ranges::replace(name, '_', ' ');
        bool is_on = simulation.effects.*effect.on && !has_none;
        if (ui::checkbox(name.c_str(), is_on)) {
            simulated::PlantEffects effects = simulation.effects;
            effects.*effect.on = is_on;
            state.error = error_text_of([&] { session.set_effects(effects); });
        }
        if (is_chosen) {
            ui::explain("the scene's model (--model auto) chooses the effects");
        } else if (has_none) {
            ui::explain("this device is exactly as its file says: start with --device-seed for "
                        "one with deviations of its own");
        } else if (effect.on == &simulated::PlantEffects::motor_tolerances ||
                   effect.on == &simulated::PlantEffects::current_sensing) {
            ui::explain("changes what the device is known to be: it is released, and starts again");
        }
    }
    ImGui::EndTable();
}

} // namespace

void draw_plant_tab(session::Session &session, PlantTabState &state) {
    draw_device_link(session, state);
    if (state.draw_assistant_offer) {
        state.draw_assistant_offer();
    }
    draw_rate(session, state);
    if (session.device().has_world()) {
        ImGui::SameLine();
        draw_delay(session, state);
    }
    if (!state.error.empty()) {
        ui::wrapped(kDanger, "{}", state.error);
    }
    if (session.is_exchanging() && session.servo().speed() < 1.0) {
        ui::wrapped(kWarning, "the device is released before it starts again: at this speed that "
                              "takes a while");
    }
    if (session.device().has_world()) {
        draw_effects(session, state);
    }
}

} // namespace springdrive::app

// Which device the session has, the connection to it, its rate, delay and effects.
#include "app/host/folders.h"
#include "app/panels/panels.h"
#include "app/widgets/widgets.h"
#include "base/input_error.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace springdrive::app {

namespace {

using factory::DeviceKind;

std::string name_of_offer(const session::DeviceChoice &choice) {
    switch (choice.kind) {
    case DeviceKind::simulated:
        return "simulated " + choice.file.stem().string();
    case DeviceKind::emulated:
        return "emulated " + choice.file.stem().string();
    case DeviceKind::usb:
        break;
    }
    return "USB " + (choice.serial.empty() ? "board" : choice.serial);
}

/// What the session has, with the serial number of a board that was the only one.
session::DeviceChoice present_choice(const session::Session &session) {
    session::DeviceChoice choice = session.device_choice();
    if (choice.kind == DeviceKind::usb) {
        choice.serial = session.device().identity().serial;
    }
    return choice;
}

/// Simulated and emulated devices, by their files.
std::vector<DeviceOffer> simulated_offers() {
    std::vector<DeviceOffer> all;
    std::error_code ignored;
    for (const auto &entry :
         std::filesystem::directory_iterator(asset_folder() / "devices", ignored)) {
        if (entry.path().extension() == ".toml") {
            all.push_back({{entry.path(), DeviceKind::simulated, ""}, ""});
            all.push_back({{entry.path(), DeviceKind::emulated, ""}, ""});
        }
    }
    std::ranges::sort(all, {}, [](const DeviceOffer &offer) {
        return std::pair(offer.choice.kind, offer.choice.file);
    });
    return all;
}

/// Adds the boards on USB, which are taken to be what the present file says, once they answered.
void take_survey(const session::Session &session, PlantTabState &state) {
    state.error = error_text_of([&] {
        if (const auto present = state.survey.take()) {
            for (const factory::PresentDevice &device : *present) {
                if (device.kind == DeviceKind::usb) {
                    state.offers.push_back(
                        {{session.device_choice().file, DeviceKind::usb, device.serial},
                         device.problem});
                }
            }
        }
    });
}

void draw_offers(session::Session &session, PlantTabState &state) {
    if (ImGui::IsWindowAppearing()) { // USB is asked when the list is opened
        state.offers = simulated_offers();
        state.survey.start([](BackgroundTalk &) { return factory::devices_present(); });
    }
    if (state.survey.is_busy()) {
        take_survey(session, state);
    }
    const std::string present = name_of_offer(present_choice(session));
    for (const DeviceOffer &offer : state.offers) {
        const ui::Disabled disabled(!offer.problem.empty());
        const std::string name = name_of_offer(offer.choice);
        if (ui::selectable(name.c_str(), name == present) && name != present) {
            state.error = error_text_of([&] { session.exchange_device(offer.choice); });
        }
        if (!offer.problem.empty()) {
            ui::explain(offer.problem);
        }
    }
    if (state.survey.is_busy()) {
        ui::text(kFaintInk, "asking the boards on USB…");
    } else if (std::ranges::none_of(state.offers, [](const DeviceOffer &offer) {
                   return offer.choice.kind == DeviceKind::usb;
               })) {
        ui::text(kFaintInk, "no USB board is connected");
        if (ui::selectable("doctor…", false)) {
            state.doctor.ask("usb", session.servo().rate_hz());
        }
    }
}

void draw_chooser(session::Session &session, PlantTabState &state) {
    const ui::Disabled disabled(session.is_exchanging());
    ImGui::SetNextItemWidth(-1.0F);
    const ui::DropDown list("##device", name_of_offer(present_choice(session)).c_str());
    if (list) {
        draw_offers(session, state);
    }
}

void draw_zeroing(session::Session &session, PlantTabState &state) {
    ui::wrapped(kWarning, "The board does not know where the device is. Hold the upper arm level "
                          "and the forearm hanging, then:");
    if (ui::button("zero here")) {
        state.error = error_text_of([&] { session.zero_device(Vector3::Zero()); });
    }
    ui::explain("declares all angles zero: links square to each other, tip at the origin. No motor "
                "is driven before");
}

/// Of an emulated board.
void draw_cable(session::Session &session, PlantTabState &state) {
    factory::EmulatedDevice *const emulated = session.device().emulated();
    if (emulated == nullptr) {
        return;
    }
    const ui::Disabled disabled(session.is_in_exclusive_use());
    const bool is_plugged = emulated->is_plugged();
    if (ui::button(is_plugged ? "pull its cable###cable" : "plug it in###cable")) {
        session.servo().paused([&] { emulated->set_plugged(!is_plugged); });
        state.error.clear();
    }
    ui::explain("of the emulated board, to see what happens then");
}

/// A count that should be none.
void show_count(const char *name, std::uint64_t count, const char *explanation) {
    ui::text(count == 0 ? kFaintInk : kWarning, "{} {}", name, count);
    ui::explain(explanation);
}

void show_link(const session::Session &session, const device::LinkStatus &link) {
    const double period_s = session.servo().period_s();
    const bool is_lost = session.latest().health == device::DeviceHealth::lost;
    ui::text(is_lost ? kDanger : kInk, "Link: {}", is_lost ? "lost" : link.speed);
    ImGui::SameLine();
    ui::text(kFaintInk, "board {}", link.board_state);
    ui::text(kInk, "d {:.2f} periods", link.delay_s / period_s);
    ui::explain(ui::formatted("from a measurement to the command computed from it, on the board's "
                              "clock, mean of the last 256; at most {:.2f} lately. Used by the "
                              "stability margins",
                              link.longest_delay_s / period_s));
    ImGui::SameLine();
    ui::text(kInk, "round trip {:.0f} us", 1e6 * link.round_trip_s);
    ui::explain(ui::formatted("of packets alone, without the board's waiting; at most {:.0f} us "
                              "lately",
                              1e6 * link.longest_round_trip_s));
    ImGui::SameLine();
    ui::text(kFaintInk, "{} reports", link.reports);
    show_count("lost", link.lost, "reports that never came");
    ImGui::SameLine();
    show_count("late", link.late, "ticks whose newest report was measured for an earlier one");
    ImGui::SameLine();
    show_count("absent", link.absent, "ticks without a new report");
    ImGui::SameLine();
    show_count("damaged", link.corrupt, "packets that are no valid report");
    ImGui::SameLine();
    show_count("old", link.repeated + link.stale, "reports that came twice, or after newer ones");
    ImGui::SameLine();
    show_count("rejected", link.rejected + link.unsent,
               "commands that the board rejected, or that could not be sent");
    if (!link.warning.empty()) {
        ui::wrapped(kWarning, "{}", link.warning);
    }
    if (!link.last_problem.empty()) {
        ui::text(kWarning, "last: {}", link.last_problem);
    }
}

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
           effect.on == &simulated::PlantEffects::current_sensing ||
           effect.on == &simulated::PlantEffects::brush_voltage ||
           effect.on == &simulated::PlantEffects::torque_ripple;
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

/// Which device, zeroing, and the connection to one on USB.
void draw_device_link(session::Session &session, PlantTabState &state) {
    draw_chooser(session, state);
    const auto refused = std::ranges::find_if(
        state.offers, [](const DeviceOffer &offer) { return !offer.problem.empty(); });
    if (refused != state.offers.end()) {
        ui::wrapped(kWarning, "{}: {}", name_of_offer(refused->choice), refused->problem);
        state.doctor.offer(name_of(refused->choice), session.servo().rate_hz());
    }
    state.doctor.draw();
    const bool is_open = session.device().state() == factory::DeviceState::open;
    if (is_open && !session.is_exchanging()) {
        draw_zeroing(session, state);
    }
    if (const auto link = session.device().device().link()) {
        show_link(session, *link);
    }
    draw_cable(session, state);
}

} // namespace

std::string device_text(const session::Session &session) {
    const session::DeviceChoice &choice = session.device_choice();
    switch (choice.kind) {
    case DeviceKind::simulated:
        return session.description().name + ", simulated";
    case DeviceKind::emulated:
        return session.description().name + ", emulated";
    case DeviceKind::usb:
        break;
    }
    return session.description().name + " on USB, " + session.device().identity().serial;
}

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
    ui::show_error(state.error);
    if (session.is_exchanging() && session.servo().speed() < 1.0) {
        ui::wrapped(kWarning, "the device is released before it starts again: at this speed that "
                              "takes a while");
    }
    if (session.device().has_world()) {
        draw_effects(session, state);
    }
}

} // namespace springdrive::app

#include "app/panels/panels.h"
#include "app/widgets/widgets.h"
#include "base/input_error.h"
#include "engine/lab/loops/stability_case.h"
#include "engine/session/telemetry_history.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace springdrive::app {

namespace {

using simulated::StimulusKind;

constexpr std::array<const char *, 4> kDirectionLabels{"into the surface", "along x", "along y",
                                                       "along z"};

/// Without contact: down.
Vector3 direction_of(const session::Session &session, StimulusDirection direction) {
    switch (direction) {
    case StimulusDirection::into_surface:
        break;
    case StimulusDirection::x:
        return Vector3::UnitX();
    case StimulusDirection::y:
        return Vector3::UnitY();
    case StimulusDirection::z:
        return Vector3::UnitZ();
    }
    const contact::Contact &contact = session.latest().contact;
    return contact.touching ? Vector3(-contact.normal) : Vector3(-Vector3::UnitY());
}

void start(session::Session &session, HandTabState &state) {
    simulated::HandStimulus stimulus = state.stimulus;
    stimulus.direction = direction_of(session, state.direction);
    session.hand().play(stimulus);
    state.played = stimulus;
    state.started_s = session.plot_time_s();
    state.measured.reset();
    state.predicted_N_per_m = tip_stiffness_N_per_m(session, stimulus.direction);
}

void show_result(const session::Session &session, HandTabState &state) {
    if (!state.played) {
        return;
    }
    const double end_s = state.started_s + state.played->duration_s;
    if (session.plot_time_s() < end_s) {
        ui::progress("playing",
                     (session.plot_time_s() - state.started_s) / state.played->duration_s,
                     "playing");
        return;
    }
    if (!state.measured) {
        state.measured =
            measured_stiffness(session.servo().history().store(), state.started_s, end_s);
    }
    if (std::isnan(state.measured->slope_N_per_m)) {
        ui::wrapped(kFaintInk, "no stiffness measured: the tip was not pressed deeper by more than "
                               "a few encoder counts");
        return;
    }
    ui::text(kInk, "measured {:.2f} ± {:.2f} N/mm, predicted {:.2f} N/mm",
             1e-3 * state.measured->slope_N_per_m, 1e-3 * state.measured->deviation_N_per_m,
             1e-3 * state.predicted_N_per_m);
    ui::explain("measured: slope of the force along the normal over the depth of the tip, both as\n"
                "the servo knows them, with its standard deviation if ticks were independent.\n"
                "Predicted: static stiffness of the coupling at rest, without friction; a fast\n"
                "signal meets more");
}

void edit(const char *label, double &value, double per_si, double minimum, double maximum,
          const char *format) {
    double shown = value * per_si;
    ImGui::SetNextItemWidth(7.0F * ImGui::GetFontSize());
    if (ui::slider_with_number(label, shown, minimum, maximum, format)) {
        value = shown / per_si;
    }
}

struct Grip {
    const char *name;
    double firmness; ///< see hand_of_firmness
};

constexpr std::array<Grip, 3> kGrips{
    {{"light hand", 0.0}, {"relaxed hand", 0.5}, {"firm hand", 1.0}}};

device::HandParameters hand_of(const device::HandParameters &before, const Grip &grip) {
    const loops::Hand requested = loops::hand_of_firmness(grip.firmness);
    device::HandParameters hand = before;
    hand.mass_kg = requested.mass_kg;
    hand.damping_Ns_per_m = requested.damping_Ns_per_m;
    hand.stiffness_N_per_m = requested.stiffness_N_per_m;
    return hand;
}

void draw_grip(session::Session &session, HandTabState &state) {
    const device::HandParameters &now = session.simulation().hand;
    const auto *const grip = std::ranges::find_if(kGrips, [&now](const Grip &some) {
        return hand_of(now, some).stiffness_N_per_m == now.stiffness_N_per_m;
    });
    ImGui::SetNextItemWidth(8.6F * ImGui::GetFontSize());
    {
        const ui::DropDown list("##grip", grip != kGrips.end() ? grip->name : "other hand");
        for (const Grip &some : kGrips) {
            if (list && ui::selectable(some.name, &some == grip)) {
                state.error = error_text_of([&] { session.set_hand(hand_of(now, some)); });
            }
        }
    }
    ui::explain(ui::formatted("the simulated hand: {:.0f} g, {:.1f} N·s/m, {:.0f} N/m, at most "
                              "{:.0f} N",
                              1e3 * now.mass_kg, now.damping_Ns_per_m, now.stiffness_N_per_m,
                              now.max_force_N));
}

void draw_paths(session::Session &session, HandTabState &state) {
    draw_grip(session, state);
    ImGui::SameLine();
    if (session.hand().follows_path()) {
        if (ui::button("stop the path")) {
            session.leave_path();
        }
        return;
    }
    if (ui::button("scripted touch")) {
        state.error = error_text_of([&] { session.follow_script(); });
    }
    ui::explain(
        "the hand moves above the scene, presses and strokes it as `springdrive touch` does");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1.0F);
    if (ui::text_field("##path", "path: a CSV file t,x,y,z", state.path)) {
        follow_path_file(session, state, state.path);
    }
}

} // namespace

void follow_path_file(session::Session &session, HandTabState &state,
                      const std::filesystem::path &file) {
    state.path = file.string();
    state.error = error_text_of([&] { session.follow_path(simulated::HandPath::read_csv(file)); });
}

StiffnessMeasured measured_stiffness(const record::ChannelStore &store, double from_s,
                                     double to_s) {
    const auto channel = [](const char *name) { return session::channel_named(name).value(); };
    const std::size_t depth_channel = channel("penetration_m");
    const std::array<std::size_t, 3> force{channel("force_x_N"), channel("force_y_N"),
                                           channel("force_z_N")};
    const std::array<std::size_t, 3> normal{channel("normal_x"), channel("normal_y"),
                                            channel("normal_z")};
    double n = 0.0;
    double sum_x = 0.0;
    double sum_y = 0.0;
    double sum_xx = 0.0;
    double sum_xy = 0.0;
    double sum_yy = 0.0;
    for (std::uint64_t row = store.row_at(from_s); row < store.end() && store.time_s(row) <= to_s;
         ++row) {
        const double x = store.value(depth_channel, row);
        if (std::isnan(x)) {
            continue; // not touching
        }
        double y = 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
            y += store.value(force[i], row) * store.value(normal[i], row);
        }
        n += 1.0;
        sum_x += x;
        sum_y += y;
        sum_xx += x * x;
        sum_xy += x * y;
        sum_yy += y * y;
    }
    const double of_x = sum_xx - sum_x * sum_x / n;
    constexpr double kMinSpread_m = 5e-5; // two encoder counts at the tip
    if (n < 10.0 || !(std::sqrt(of_x / n) > kMinSpread_m)) {
        return {};
    }
    const double of_xy = sum_xy - sum_x * sum_y / n;
    const double of_y = sum_yy - sum_y * sum_y / n;
    const double slope = of_xy / of_x;
    const double residual = std::max(0.0, of_y - slope * of_xy);
    return {slope, std::sqrt(residual / ((n - 2.0) * of_x))};
}

void draw_hand_tab(session::Session &session, HandTabState &state) {
    if (!session.hand().is_simulated()) {
        ui::wrapped(kFaintInk, "The hand is a real one.");
        return;
    }
    draw_paths(session, state);
    simulated::HandStimulus &stimulus = state.stimulus;
    const float font = ImGui::GetFontSize();
    ImGui::SetNextItemWidth(8.6F * font);
    const auto kinds = std::span<const char *const>(simulated::kStimulusLabels).subspan(1);
    auto index = static_cast<std::size_t>(stimulus.kind) - 1;
    if (ui::choice("##kind", index, kinds)) {
        stimulus.kind = static_cast<StimulusKind>(index + 1);
    }
    ImGui::SameLine();
    ImGui::SetNextItemWidth(8.6F * font);
    ui::choice("##direction", state.direction, kDirectionLabels);
    ImGui::SameLine();
    if (ui::button("play")) {
        start(session, state);
    }
    ui::explain("moves the simulated hand's target, beside where it is held");
    edit("##amplitude", stimulus.amplitude_m, 1e3, 0.1, 20.0, "%.1f mm");
    ImGui::SameLine();
    edit("##duration", stimulus.duration_s, 1.0, 0.1, 30.0, "%.1f s");
    if (stimulus.kind == StimulusKind::chirp) {
        edit("##from", stimulus.from_Hz, 1.0, 0.2, 100.0, "from %.1f Hz");
        ImGui::SameLine();
        edit("##to", stimulus.to_Hz, 1.0, 0.2, 100.0, "to %.1f Hz");
    }
    show_result(session, state);
    ui::show_error(state.error);
}

} // namespace springdrive::app

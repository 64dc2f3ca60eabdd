#include "app/host/folders.h"
#include "app/panels/panels.h"
#include "app/plots/channels.h"
#include "app/widgets/widgets.h"
#include "base/input_error.h"
#include "base/new_file.h"
#include "device/core/phantom/kinematics.h"
#include "engine/servo/safety_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

namespace springdrive::app {

namespace {

constexpr double kMinShare = 0.02; // of the device's limit; lower values always trip

/// The value that is held against a limit, in its SI unit; NaN where the window does not know it.
double live_value(const session::Session &session, double servo::SafetyLimits::*limit) {
    using servo::SafetyLimits;
    const servo::ServoSample &now = session.latest();
    if (limit == &SafetyLimits::voltage_V) {
        return now.command.e_W_V.cwiseAbs().maxCoeff();
    }
    if (limit == &SafetyLimits::current_A) {
        return now.current_A.cwiseAbs().maxCoeff();
    }
    if (limit == &SafetyLimits::winding_C) {
        return std::max({now.winding[0].max_C, now.winding[1].max_C, now.winding[2].max_C});
    }
    if (limit == &SafetyLimits::tip_force_N) {
        return now.tip_force_N.norm();
    }
    const device::DeviceDescription &device = session.description();
    const Vector3 q_rad = device::joint_from_motor(device.geometry, now.theta_rad);
    if (limit == &SafetyLimits::tip_speed_m_per_s) {
        return (device::motor_jacobian(device.geometry, q_rad) * now.theta_rate_rad_per_s).norm();
    }
    if (limit == &SafetyLimits::beyond_stops_rad) {
        return servo::beyond_limits(device.joint_limits, q_rad, 0.0).max_excess_rad();
    }
    if (limit == &SafetyLimits::generated_energy_J) {
        return now.generated_energy_J;
    }
    if (limit == &SafetyLimits::late_s) {
        return now.missed_in_a_row * session.servo().period_s();
    }
    return std::nan("");
}

/// A slider from nearly zero to the device's limit, and a button to restore that.
bool edit_limit(const servo::SafetyLimit &limit, double device_value, double live,
                double &requested) {
    const double scale = limit.shown_per_si;
    const float font = ImGui::GetFontSize();
    double shown = scale * std::min(device_value, requested);
    const double maximum = scale * device_value;
    const double minimum = kMinShare * maximum;
    const ui::Scope scope(limit.name);
    const ui::ExplainedRow row(explanation_of(std::string("limit_") + limit.name));
    ImGui::AlignTextToFramePadding();
    ui::text(kFaintInk, "{}", limit.what);
    ImGui::SameLine(10.6F * font);
    ImGui::AlignTextToFramePadding();
    if (std::isnan(live)) {
        ui::text(kFaintInk, "–");
    } else {
        // Orange from where the force is held back on.
        const double digits = scale * live < 1e-3 * maximum ? 0.0 : scale * live;
        ui::text(digits > 0.9 * shown ? kWarning : kInk, "{:.3g}", digits);
    }
    ImGui::SameLine(13.6F * font);
    ImGui::SetNextItemWidth(6.6F * font);
    bool changed = ui::slider_with_number("##slider", shown, minimum, maximum, "%.3g");
    ImGui::SameLine();
    ui::text(kFaintInk, "{}", limit.unit);
    ImGui::SameLine(23.0F * font);
    if (ui::button("\u21BA##reset")) {
        shown = maximum;
        changed = true;
    }
    ui::explain(ui::formatted("reset to the device's limit, {:.3g} {}", maximum, limit.unit));
    if (changed) {
        requested = shown >= maximum ? device_value : shown / scale;
    }
    return changed;
}

constexpr double kMicro = 1e6;

/// Which limit holds the command back, and how near it is.
std::string held_force_text(const session::Session &session) {
    const servo::ServoSample &now = session.latest();
    const servo::ForceLimit by = now.active_limits.force;
    if (by == servo::ForceLimit::singular) {
        return "held back: no force in this pose";
    }
    if (by == servo::ForceLimit::tip_force) {
        return ui::formatted("held back: force {:.1f} of {:.1f} N", now.tip_force_N.norm(),
                             now.limits.tip_force_N);
    }
    const auto motor =
        static_cast<std::size_t>(by) - static_cast<std::size_t>(servo::ForceLimit::current1);
    return ui::formatted(
        "held back: motor {} at {:.1f} of {:.1f} A", motor + 1,
        std::abs(now.current_A[static_cast<Eigen::Index>(motor)]),
        std::min(session.description().motor[motor].peak_current_A, now.limits.current_A));
}

std::string held_back_text(const session::Session &session) {
    const servo::ActiveLimits &active_limits = session.latest().active_limits;
    return active_limits.holds_force() ? held_force_text(session)
           : active_limits.at_edge     ? "edge of the workspace"
           : active_limits.voltage     ? "voltage limited"
                                       : "";
}

void show_state(const session::Session &session) {
    const servo::ServoSample &now = session.latest();
    if (session.servo().speed() == 0.0) {
        ui::text(kWarning, "paused,");
        ImGui::SameLine();
    }
    switch (now.safety.state) {
    case servo::SafetyState::waiting:
        ui::text(kWarning, "{}",
                 session.is_kept_released() ? "held braking by the assistant: tab Plant"
                 : !session.is_zeroed()     ? "waiting to be zeroed: tab Plant"
                 : now.contact.touching     ? "waiting: lift the tip off the surface"
                                            : "waiting for the tip to rest in free space");
        break;
    case servo::SafetyState::starting:
        ui::text(kWarning, "starting, gains at {:.0f} %", 100.0 * now.safety.ramp);
        break;
    case servo::SafetyState::running:
        ui::text(kGood, "running");
        break;
    case servo::SafetyState::releasing:
        ui::text(kWarning, "releasing, gains at {:.0f} %", 100.0 * now.safety.ramp);
        break;
    case servo::SafetyState::tripped:
        ui::wrapped(kDanger, "stopped: {}", servo::description(now.safety));
        if (ImGui::GetItemRectSize().x + ImGui::GetStyle().ItemSpacing.x +
                ImGui::CalcTextSize(device_text(session).c_str()).x <
            ImGui::GetContentRegionAvail().x) {
            ImGui::SameLine();
        }
        ui::text(kFaintInk, "{}", device_text(session));
        return;
    }
    if (const std::string why = held_back_text(session); !why.empty()) {
        ImGui::SameLine();
        ui::text(kWarning, "{}", why);
        ui::explain("the steady currents and force of the command are kept below the limits,\n"
                    "so that pressing hard meets a greatest force instead of a stop");
    }
    ImGui::SameLine();
    ui::text(kFaintInk, "{}", device_text(session));
}

void show_duration(const char *name, const servo::DurationHistogram &durations,
                   const char *explanation) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ui::text(kFaintInk, "{}", name);
    ui::explain(explanation);
    const ui::Scope scope(name);
    for (const double value : {durations.quantile_s(0.5), durations.quantile_s(0.99),
                               durations.quantile_s(0.999), durations.longest_s()}) {
        ImGui::TableNextColumn();
        if (durations.count() > 0) {
            ui::text(kInk, "{:.1f}", kMicro * value);
        } else {
            ui::text(kFaintInk, "–");
        }
    }
}

void show_durations(const servo::ServoStatistics &statistics) {
    if (ImGui::BeginTable("durations", 5, ImGuiTableFlags_SizingStretchProp)) {
        ImGui::TableNextRow();
        for (const char *title : {"all in µs", "median", "99 %", "99.9 %", "longest"}) {
            ImGui::TableNextColumn();
            ui::text(kFaintInk, "{}", title);
        }
        show_duration("period", statistics.period(),
                      "from the start of a tick to the start of the next");
        show_duration("jitter", statistics.lateness(), "from a tick's deadline to its start");
        show_duration("compute", statistics.compute(), "from a measurement to its command");
        ImGui::EndTable();
    }
}

void show_rate(const session::Session &session) {
    const servo::ServoStatistics &statistics = session.servo().statistics();
    ui::text(kFaintInk, "set {:.0f} Hz", session.servo().rate_hz());
    if (statistics.period().count() > 0) {
        ImGui::SameLine();
        ui::text(kInk, "actual {:.1f} Hz", 1.0 / statistics.period().mean_s());
    }
    ImGui::SameLine();
    const std::uint64_t lost = session.servo().lost_samples();
    if (session.device().device().clock() == device::DeviceClock::servo) {
        // No deadlines are missed: the simulation pauses instead.
        ui::text(kFaintInk, "paused {:.0f} ms", 1e3 * session.servo().stalls().seconds);
    } else {
        const std::uint64_t missed = statistics.missed_deadlines();
        ui::text(missed == 0 ? kFaintInk : kWarning, "missed {}", missed);
    }
    ImGui::SameLine();
    ui::text(lost == 0 ? kFaintInk : kWarning, "lost {}", lost);
    ui::explain("samples that the window was too slow to take; a record has its own count");
}

void toggle_recording(session::Session &session, ServoPanelState &state) {
    state.record_error.clear();
    if (session.recording().is_running()) {
        session.recording().stop();
        return;
    }
    state.record_error = error_text_of(
        [&] { session.start_recording(in_output_dir(dated_name("springdrive") + ".rec")); });
}

void show_recording(session::Session &session, ServoPanelState &state) {
    const bool recording = session.recording().is_running();
    const record::RecorderStatus status = session.recording().status();
    const double recorded_s = static_cast<double>(status.rows) / session.servo().rate_hz();
    // The same width in all states, so that the next button does not move.
    const float width = ImGui::CalcTextSize("stop, 10000 s").x + ImGui::GetFontSize();
    const std::string label =
        recording ? ui::formatted("stop, {:.0f} s###record", recorded_s) : "record###record";
    if (ui::button(label.c_str(), {width, 0.0F})) {
        toggle_recording(session, state);
    }
    if (session.recording().file().empty()) {
        ui::explain("writes every tick to a file in " + output_dir_text());
    } else {
        ui::explain(ui::formatted("{}: {:.1f} s, {:.1f} MB, {} ticks lost",
                                  session.recording().file().string(), recorded_s,
                                  1e-6 * static_cast<double>(status.bytes), status.lost));
    }
}

/// True if it is to be kept.
bool show_keeping(const session::Session &session, const SessionKeeper &keeper) {
    const bool is_asked = ui::button("keep");
    const double written_MB = 1e-6 * static_cast<double>(keeper.bytes_to_write(session));
    ui::explain(ui::formatted(
        "keeps this session in a folder: what is still in memory ({:.0f} MB as a record) and what\n"
        "follows, tunings, notes, log and a picture. Again: brings it up to date. Ctrl+S",
        written_MB));
    if (keeper.is_writing()) {
        ImGui::SameLine();
        ui::text(kFaintInk, "writing");
    } else if (keeper.is_kept()) {
        ImGui::SameLine();
        const ui::Scope scope("kept");
        ui::text(kGood, "kept");
        ui::explain(keeper.folder().lexically_normal().string());
    } else {
        ImGui::SameLine();
        ui::text(kFaintInk, "{:.0f} MB", written_MB);
    }
    return is_asked;
}

void show_errors(const session::Session &session, const SessionKeeper &keeper,
                 const ServoPanelState &state) {
    for (const std::string &error :
         {state.record_error, session.recording().status().error, keeper.error()}) {
        ui::show_error(error);
    }
}

void show_notes(SessionKeeper &keeper) {
    const float line = ImGui::GetTextLineHeightWithSpacing();
    const float height = std::max(2.5F * line, ImGui::GetContentRegionAvail().y - line);
    ui::text_box("##notes", keeper.notes, {-1.0F, height});
    ui::text(kFaintInk, "{}",
             keeper.folder().empty() ? "kept with the session: Ctrl+S"
                                     : keeper.folder().filename().string() + "; Ctrl+S saves them");
}

struct Speed {
    double value;
    const char *label;
};

constexpr std::array<Speed, 5> kSpeeds{
    {{1.0, "real time"}, {0.5, "1/2"}, {0.1, "1/10"}, {0.01, "1/100"}, {0.0, "paused"}}};

void show_speed(session::Session &session) {
    session::ServoRun &servo = session.servo();
    if (!servo.can_change_speed()) {
        return;
    }
    const auto *const now = std::ranges::find(kSpeeds, servo.speed(), &Speed::value);
    ImGui::SetNextItemWidth(6.4F * ImGui::GetFontSize());
    {
        const ui::DropDown list("##speed", now != kSpeeds.end() ? now->label : "");
        for (const Speed &speed : kSpeeds) {
            if (list && ui::selectable(speed.label, speed.value == servo.speed())) {
                servo.set_speed(speed.value);
            }
        }
    }
    ui::explain("speed of the simulated device, its hand and its servo; key P pauses");
    ImGui::SameLine();
    if (enabled_button("step", servo.speed() == 0.0)) {
        servo.step();
    }
    ui::explain("one tick, while it is paused; key .");
    ImGui::SameLine();
}

void show_log(const EventLog &log) {
    if (log.events().empty()) {
        ui::text(kFaintInk, "nothing happened yet");
    }
    constexpr std::size_t kMaxShown = 200;
    std::size_t shown = 0;
    for (auto event = log.events().rbegin(); event != log.events().rend() && shown < kMaxShown;
         ++event, ++shown) {
        const ImVec4 &ink = event->kind == EventLog::Kind::trip     ? kDanger
                            : event->kind == EventLog::Kind::change ? kInk
                                                                    : kFaintInk;
        ui::wrapped(ink, "{:.2f} s  {}", event->time_s, event->what);
    }
}

void show_timing(const session::Session &session) {
    show_durations(session.servo().statistics());
    show_rate(session);
    for (const std::string &warning : session.warnings().all()) {
        // The problem; the tooltip adds the remedy after the semicolon.
        ui::wrapped(kWarning, "{}", warning.substr(0, warning.find(';')));
        ui::explain(warning);
    }
}

/// The safety limits with what is held against them, and sliders to lower them.
void draw_limits_tab(session::Session &session) {
    const servo::SafetyLimits device = servo::limits_of(session.description());
    servo::SafetyLimits requested = session.servo().inputs().limits;
    bool changed = false;
    for (const servo::SafetyLimit &limit : servo::kSafetyLimits) {
        changed |= edit_limit(limit, device.*limit.value, live_value(session, limit.value),
                              requested.*limit.value);
    }
    if (changed) {
        session.servo().lower_limits(requested);
    }
    ui::wrapped(kFaintInk,
                "Now, and the limit: set by the device file, it can only be lowered here.");
}

} // namespace

bool draw_servo_panel(session::Session &session, const EventLog &log, SessionKeeper &keeper,
                      ServoPanelState &state, const Rectangle &place) {
    const ui::Panel panel("Servo", place, ImGuiWindowFlags_NoTitleBar);
    show_state(session);
    show_speed(session);
    show_recording(session, state);
    ImGui::SameLine();
    const bool keeps = show_keeping(session, keeper);
    show_errors(session, keeper, state);
    const ui::Tabs tabs("servo");
    if (!tabs) {
        return keeps;
    }
    if (const ui::Tab timing("Timing"); timing) {
        show_timing(session);
    }
    if (const ui::Tab limits("Limits"); limits) {
        draw_limits_tab(session);
    }
    if (const ui::Tab events("Log"); events) {
        show_log(log);
    }
    if (const ui::Tab notes("Notes"); notes) {
        show_notes(keeper);
    }
    // Among the tabs: the warnings themselves may be scrolled out of the panel.
    if (!session.warnings().all().empty() && ui::tab_button("doctor…")) {
        state.doctor.ask(name_of(session.device_choice()), session.servo().rate_hz());
    }
    state.doctor.draw();
    return keeps;
}

} // namespace springdrive::app

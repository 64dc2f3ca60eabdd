#include "app/panels/panels.h"
#include "app/widgets/widgets.h"
#include "base/input_error.h"

#include <array>
#include <cstdint>
#include <ctime>
#include <string>

namespace springdrive::app {

namespace {

constexpr double kMicro = 1e6;

void show_state(const session::Session &session) {
    const servo::ServoSample &now = session.latest();
    switch (now.safety.state) {
    case servo::SafetyState::waiting:
        ui::text(kWarning, "{}",
                 now.contact.touching ? "waiting: lift the tip off the surface"
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
        return;
    }
    if (now.held_back.force || now.held_back.voltage || now.held_back.at_edge) {
        ImGui::SameLine();
        ui::text(kWarning, "{}",
                 now.held_back.force     ? "force limited"
                 : now.held_back.at_edge ? "edge of the workspace"
                                         : "voltage limited");
    }
    ImGui::SameLine();
    ui::text(kFaintInk, "{}", session.description().name);
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
        ui::text(kFaintInk, "paused {:.0f} ms", 1e3 * session.servo().standstills().seconds);
    } else {
        const std::uint64_t missed = statistics.missed_deadlines();
        ui::text(missed == 0 ? kFaintInk : kWarning, "missed {}", missed);
    }
    ImGui::SameLine();
    ui::text(lost == 0 ? kFaintInk : kWarning, "lost {}", lost);
    ui::explain("samples that the window was too slow to take; a record has its own count");
}

/// "springdrive-20240531-123456.rec", in the current directory.
std::string name_of_new_record() {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    localtime_r(&now, &parts);
    std::array<char, 64> text{};
    std::strftime(text.data(), text.size(), "springdrive-%Y%m%d-%H%M%S.rec", &parts);
    return text.data();
}

void toggle_recording(session::Session &session, ServoPanelState &state) {
    state.record_error.clear();
    if (session.recording().is_running()) {
        session.recording().stop();
        return;
    }
    try {
        session.start_recording(name_of_new_record());
    } catch (const InputError &error) {
        state.record_error = error.what();
    }
}

void show_recording(session::Session &session, ServoPanelState &state) {
    const bool recording = session.recording().is_running();
    // The same width in both states, so that the next button does not move.
    const float width = ImGui::CalcTextSize("stop recording").x + ImGui::GetFontSize();
    if (ui::button(recording ? "stop recording" : "record", {width, 0.0F})) {
        toggle_recording(session, state);
    }
    ui::explain(recording ? "ends the file"
                          : "writes every tick to a file in the folder where springdrive was "
                            "started");
    ImGui::SameLine();
    if (ui::button("limits")) {
        ImGui::OpenPopup("limits");
    }
    draw_limits_popup(session);
    const record::RecorderStatus status = session.recording().status();
    const std::string &error = state.record_error.empty() ? status.error : state.record_error;
    if (!error.empty()) {
        ui::wrapped(kDanger, "{}", error);
    } else if (!session.recording().file().empty()) {
        ImGui::SameLine();
        ui::text(recording ? kDanger : kFaintInk, "{} {:.1f} s, {:.1f} MB",
                 recording ? "recorded" : "saved",
                 static_cast<double>(status.rows) / session.servo().rate_hz(),
                 1e-6 * static_cast<double>(status.bytes));
        ui::explain(
            ui::formatted("{}, {} ticks lost", session.recording().file().string(), status.lost));
    }
}

} // namespace

void draw_servo_panel(session::Session &session, ServoPanelState &state, const Rectangle &place) {
    const ui::Panel panel("Servo", place);
    show_state(session);
    show_durations(session.servo().statistics());
    show_rate(session);
    show_recording(session, state);
    for (const std::string &remark : session.remarks().all()) {
        // The problem; the tooltip adds the remedy after the semicolon.
        ui::wrapped(kWarning, "{}", remark.substr(0, remark.find(';')));
        ui::explain(remark);
    }
}

} // namespace springdrive::app

#include "app/panels/look.h"
#include "app/panels/panels.h"
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
        ImGui::TextColored(kWarning, "%s",
                           now.contact.touching ? "waiting: lift the tip off the surface"
                                                : "waiting for the tip to rest in free space");
        break;
    case servo::SafetyState::starting:
        ImGui::TextColored(kWarning, "starting, gains at %.0f %%", 100.0 * now.safety.ramp);
        break;
    case servo::SafetyState::running:
        ImGui::TextColored(kGood, "running");
        break;
    case servo::SafetyState::releasing:
        ImGui::TextColored(kWarning, "releasing, gains at %.0f %%", 100.0 * now.safety.ramp);
        break;
    case servo::SafetyState::tripped:
        ImGui::PushStyleColor(ImGuiCol_Text, kDanger);
        ImGui::TextWrapped("stopped: %s", servo::description(now.safety).c_str());
        ImGui::PopStyleColor();
        return;
    }
    if (now.held_back.force || now.held_back.voltage || now.held_back.at_edge) {
        ImGui::SameLine();
        ImGui::TextColored(kWarning, "%s",
                           now.held_back.force     ? "force limited"
                           : now.held_back.at_edge ? "edge of the workspace"
                                                   : "voltage limited");
    }
    ImGui::SameLine();
    ImGui::TextColored(kFaintInk, "%s", session.description().name.c_str());
}

void show_duration(const char *name, const servo::DurationHistogram &durations,
                   const char *explanation) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextColored(kFaintInk, "%s", name);
    if (ImGui::IsItemHovered()) {
        ImGui::SetTooltip("%s", explanation);
    }
    for (const double value : {durations.quantile_s(0.5), durations.quantile_s(0.99),
                               durations.quantile_s(0.999), durations.longest_s()}) {
        ImGui::TableNextColumn();
        if (durations.count() > 0) {
            ImGui::Text("%.1f", kMicro * value);
        } else {
            ImGui::TextColored(kFaintInk, "–");
        }
    }
}

void show_durations(const servo::ServoStatistics &statistics) {
    if (ImGui::BeginTable("durations", 5, ImGuiTableFlags_SizingStretchProp)) {
        ImGui::TableNextRow();
        for (const char *title : {"all in µs", "median", "99 %", "99.9 %", "longest"}) {
            ImGui::TableNextColumn();
            ImGui::TextColored(kFaintInk, "%s", title);
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
    ImGui::TextColored(kFaintInk, "set %.0f Hz", session.servo().rate_hz());
    if (statistics.period().count() > 0) {
        ImGui::SameLine();
        ImGui::Text("actual %.1f Hz", 1.0 / statistics.period().mean_s());
    }
    ImGui::SameLine();
    const std::uint64_t lost = session.servo().lost_samples();
    if (session.device().device().clock() == device::DeviceClock::servo) {
        // No deadlines are missed: the simulation pauses instead.
        ImGui::TextColored(lost == 0 ? kFaintInk : kWarning, "paused %.0f ms  lost %llu",
                           1e3 * session.servo().standstills().seconds,
                           static_cast<unsigned long long>(lost));
        return;
    }
    const bool all_well = statistics.missed_deadlines() == 0 && lost == 0;
    ImGui::TextColored(all_well ? kFaintInk : kWarning, "missed %llu  lost %llu",
                       static_cast<unsigned long long>(statistics.missed_deadlines()),
                       static_cast<unsigned long long>(lost));
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
    if (ImGui::Button(recording ? "stop recording" : "record", {width, 0.0F})) {
        toggle_recording(session, state);
    }
    if (ImGui::IsItemHovered() && !recording) {
        ImGui::SetTooltip(
            "writes every tick to a file in the folder where springdrive was started");
    }
    ImGui::SameLine();
    if (ImGui::Button("limits")) {
        ImGui::OpenPopup("limits");
    }
    draw_limits_popup(session);
    const record::RecorderStatus status = session.recording().status();
    const std::string &error = state.record_error.empty() ? status.error : state.record_error;
    if (!error.empty()) {
        ImGui::PushStyleColor(ImGuiCol_Text, kDanger);
        ImGui::TextWrapped("%s", error.c_str());
        ImGui::PopStyleColor();
    } else if (!session.recording().file().empty()) {
        ImGui::SameLine();
        ImGui::TextColored(recording ? kDanger : kFaintInk, "%s %.1f s, %.1f MB",
                           recording ? "recorded" : "saved",
                           static_cast<double>(status.rows) / session.servo().rate_hz(),
                           1e-6 * static_cast<double>(status.bytes));
        if (ImGui::IsItemHovered()) {
            ImGui::SetTooltip("%s, %llu ticks lost", session.recording().file().c_str(),
                              static_cast<unsigned long long>(status.lost));
        }
    }
}

} // namespace

void draw_servo_panel(session::Session &session, ServoPanelState &state, const Rectangle &place) {
    begin_panel("Servo", place);
    show_state(session);
    show_durations(session.servo().statistics());
    show_rate(session);
    show_recording(session, state);
    for (const std::string &remark : session.remarks().all()) {
        // The problem; the tooltip adds the remedy after the semicolon.
        ImGui::PushStyleColor(ImGuiCol_Text, kWarning);
        ImGui::TextWrapped("%s", remark.substr(0, remark.find(';')).c_str());
        ImGui::PopStyleColor();
        if (ImGui::IsItemHovered()) {
            ImGui::SetTooltip("%s", remark.c_str());
        }
    }
    ImGui::End();
}

} // namespace springdrive::app

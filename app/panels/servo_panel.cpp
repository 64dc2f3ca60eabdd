#include "app/panels/look.h"
#include "app/panels/panels.h"

#include <string>

namespace springdrive {

namespace {

constexpr double kMicro = 1e6;

void show_state(Session &session) {
    const SafetyStatus &safety = session.latest().safety;
    switch (safety.state) {
    case SafetyState::starting:
        ImGui::TextColored(kWarning, "starting, gains at %.0f %%", 100.0 * safety.ramp);
        break;
    case SafetyState::running:
        ImGui::TextColored(kGood, "running");
        break;
    case SafetyState::tripped:
        ImGui::TextColored(kDanger, "stopped: %s", description(safety).c_str());
        break;
    }
    ImGui::SameLine();
    ImGui::TextColored(kFaintInk, "%s", session.device().name.c_str());
}

void show_duration(const char *name, const ServoStatistics::Duration &duration,
                   const char *explanation) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextColored(kFaintInk, "%s", name);
    if (ImGui::IsItemHovered()) {
        ImGui::SetTooltip("%s", explanation);
    }
    for (const double value : {duration.p50_s, duration.p99_s, duration.longest_s}) {
        ImGui::TableNextColumn();
        if (duration.longest_s > 0.0) {
            ImGui::Text("%.1f", kMicro * value);
        } else {
            ImGui::TextColored(kFaintInk, "–");
        }
    }
}

} // namespace

void draw_servo_panel(Session &session, const Rectangle &place) {
    begin_panel("Servo", place);
    show_state(session);
    const ServoStatistics &statistics = session.statistics();
    if (ImGui::BeginTable("durations", 4, ImGuiTableFlags_SizingStretchProp)) {
        ImGui::TableSetupColumn("µs", ImGuiTableColumnFlags_WidthStretch, 1.3F);
        ImGui::TableNextRow();
        for (const char *title : {"all in µs", "median", "99 %", "longest"}) {
            ImGui::TableNextColumn();
            ImGui::TextColored(kFaintInk, "%s", title);
        }
        show_duration("period", statistics.period, "from the start of a tick to the next one's");
        show_duration("jitter", statistics.lateness, "from a tick's deadline to its start");
        show_duration("compute", statistics.compute,
                      "from the device's answer to the next command");
        ImGui::EndTable();
    }
    ImGui::TextColored(kFaintInk, "asked %.0f Hz", session.servo_hz());
    if (statistics.period.mean_s > 0.0) {
        ImGui::SameLine();
        ImGui::Text("got %.1f Hz", 1.0 / statistics.period.mean_s);
    }
    ImGui::SameLine();
    const bool all_well = statistics.skipped == 0 && session.lost_samples() == 0;
    ImGui::TextColored(all_well ? kFaintInk : kWarning, "skipped %llu  lost %llu",
                       static_cast<unsigned long long>(statistics.skipped),
                       static_cast<unsigned long long>(session.lost_samples()));
    for (const std::string &remark : session.remarks()) {
        // What is the matter; the remedy, behind the semicolon, under the mouse.
        ImGui::TextColored(kWarning, "%s", remark.substr(0, remark.find(';')).c_str());
        if (ImGui::IsItemHovered()) {
            ImGui::SetTooltip("%s", remark.c_str());
        }
    }
    ImGui::End();
}

} // namespace springdrive

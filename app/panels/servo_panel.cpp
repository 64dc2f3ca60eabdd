#include "app/panels/look.h"
#include "app/panels/panels.h"

#include <string>

namespace springdrive {

namespace {

constexpr double kMicro = 1e6;

void show_state(const Session &session) {
    const ServoSample &now = session.latest();
    switch (now.safety.state) {
    case SafetyState::waiting:
        ImGui::TextColored(kWarning, "%s",
                           now.contact.touching ? "waiting: lift the tip off the surface"
                                                : "waiting for the tip to rest in free space");
        break;
    case SafetyState::starting:
        ImGui::TextColored(kWarning, "starting, gains at %.0f %%", 100.0 * now.safety.ramp);
        break;
    case SafetyState::running:
        ImGui::TextColored(kGood, "running");
        break;
    case SafetyState::tripped:
        ImGui::TextColored(kDanger, "stopped: %s", description(now.safety).c_str());
        break;
    }
    if (now.held_back.force || now.held_back.voltage || now.held_back.at_edge) {
        ImGui::SameLine();
        ImGui::TextColored(kWarning, "%s",
                           now.held_back.force     ? "force held at its limit"
                           : now.held_back.at_edge ? "edge of the workspace"
                                                   : "voltage held at its limit");
    }
    ImGui::SameLine();
    ImGui::TextColored(kFaintInk, "%s", session.device().name.c_str());
}

void show_duration(const char *name, const DurationHistogram &durations, const char *explanation) {
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

void show_durations(const ServoStatistics &statistics) {
    if (ImGui::BeginTable("durations", 5, ImGuiTableFlags_SizingStretchProp)) {
        ImGui::TableNextRow();
        for (const char *title : {"all in µs", "median", "99 %", "99.9 %", "longest"}) {
            ImGui::TableNextColumn();
            ImGui::TextColored(kFaintInk, "%s", title);
        }
        show_duration("period", statistics.period(), "from the start of a tick to the next one's");
        show_duration("jitter", statistics.lateness(), "from a tick's deadline to its start");
        show_duration("compute", statistics.compute(),
                      "from the device's answer to the next command");
        ImGui::EndTable();
    }
}

void show_rate(const Session &session) {
    const ServoStatistics &statistics = session.statistics();
    ImGui::TextColored(kFaintInk, "asked %.0f Hz", session.servo_hz());
    if (statistics.period().count() > 0) {
        ImGui::SameLine();
        ImGui::Text("got %.1f Hz", 1.0 / statistics.period().mean_s());
    }
    ImGui::SameLine();
    const bool all_well = statistics.missed_deadlines() == 0 && session.lost_samples() == 0;
    ImGui::TextColored(all_well ? kFaintInk : kWarning, "missed %llu  lost %llu",
                       static_cast<unsigned long long>(statistics.missed_deadlines()),
                       static_cast<unsigned long long>(session.lost_samples()));
}

} // namespace

void draw_servo_panel(Session &session, const Rectangle &place) {
    begin_panel("Servo", place);
    show_state(session);
    show_durations(session.statistics());
    show_rate(session);
    for (const std::string &remark : session.remarks()) {
        // What is the matter; the remedy, behind the semicolon, under the mouse.
        ImGui::PushStyleColor(ImGuiCol_Text, kWarning);
        ImGui::TextWrapped("%s", remark.substr(0, remark.find(';')).c_str());
        ImGui::PopStyleColor();
        if (ImGui::IsItemHovered()) {
            ImGui::SetTooltip("%s", remark.c_str());
        }
    }
    ImGui::End();
}

} // namespace springdrive

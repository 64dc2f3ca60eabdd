#include "app/panels/stability_tab.h"

#include "app/panels/look.h"

#include <algorithm>
#include <cmath>

namespace springdrive {

namespace {

constexpr double kLeastMargin = 1.0;
constexpr double kGreatestMargin = 3.0;

/// One limit: what it is, where it lies, and how far that is from here.
void show_room(const char *what, double now, const std::optional<double> &limit, const char *unit,
               const char *none) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextColored(kFaintInk, "%s", what);
    ImGui::TableNextColumn();
    if (!limit) {
        ImGui::TextColored(kFaintInk, "%s", none);
        ImGui::TableNextColumn();
        return;
    }
    ImGui::Text("%.3g %s", *limit, unit);
    ImGui::TableNextColumn();
    const double room = std::max(*limit, now) / std::max(1e-12, std::min(*limit, now));
    ImGui::TextColored(room < 1.15 ? kWarning : kInk, "× %.2f", room);
}

void show_verdict(const StabilityOutlook &outlook) {
    const bool stable = outlook.worst.is_stable();
    ImGui::TextColored(stable ? kGood : kDanger, stable ? "stable" : "UNSTABLE");
    ImGui::SameLine();
    const double rate = std::log(outlook.worst.eigenvalue) / outlook.period_s;
    const std::string who = "motor " + std::to_string(outlook.worst.member.motor + 1) + ", " +
                            outlook.worst.member.hand.name;
    if (stable) {
        ImGui::Text("with every hand; slowest: %.0f ms (%s)", -1000.0 / rate, who.c_str());
    } else {
        ImGui::Text("grows e-fold in %.1f ms (%s)", 1000.0 / rate, who.c_str());
    }
    if (ImGui::IsItemHovered()) {
        ImGui::SetTooltip("by the largest eigenvalue of the sampled loop, %.5f,\nin rigid contact, "
                          "each motor by itself, with no hand\nand with hands from light to firm",
                          outlook.worst.eigenvalue);
    }
}

void show_outlook(const Session &session, const StabilityOutlook &outlook) {
    show_verdict(outlook);
    if (ImGui::BeginTable("room", 3, ImGuiTableFlags_SizingStretchProp)) {
        const Tuning &tuning = session.tuning();
        show_room("K_P may rise to", tuning.K_P_V_per_rad, outlook.K_P_up_to, "V/rad",
                  "no limit found");
        show_room("K_D may rise to", tuning.K_D_Vs_per_rad, outlook.K_D_up_to, "V·s/rad",
                  "no limit found");
        show_room("dR may fall to", tuning.dR_Ohm, outlook.dR_down_to_Ohm, "Ω", "no limit found");
        ImGui::EndTable();
    }
}

void show_search(const Session &session, StabilityTabState &state) {
    const float font = ImGui::GetFontSize();
    ImGui::SetNextItemWidth(8.0F * font);
    ImGui::SliderScalar("margin", ImGuiDataType_Double, &state.margin, &kLeastMargin,
                        &kGreatestMargin, "× %.2f", ImGuiSliderFlags_AlwaysClamp);
    if (ImGui::IsItemHovered()) {
        ImGui::SetTooltip("by what factor K_P and K_D might be larger yet");
    }
    ImGui::SameLine();
    if (state.is_tuning()) {
        if (ImGui::Button("give up")) {
            state.stop_tuning();
        }
        ImGui::ProgressBar(static_cast<float>(state.tuning_share()));
        return;
    }
    if (ImGui::Button("find the stiffest")) {
        state.start_tuning(session);
    }
    if (ImGui::IsItemHovered()) {
        ImGui::SetTooltip("K_P, K_D and λ for the stiffest contact with this dR, map, servo rate\n"
                          "and delay that every hand finds stable at any η; in force at once");
    }
}

void show_found(Session &session, StabilityTabState &state) {
    if (!state.message().empty()) {
        ImGui::TextWrapped("%s", state.message().c_str());
    }
    if (!state.found()) {
        return;
    }
    const TuningMargins &margins = state.found()->margins;
    ImGui::Text("K_DC %.3g N·m/rad; gains × %.2f, dR to %.3g Ω", margins.K_DC_Nm_per_rad,
                margins.gain, margins.least_dR_Ohm);
    if (ImGui::IsItemHovered()) {
        ImGui::SetTooltip("stable on %zu loops; %d more samples of delay would be\n"
                          "borne; at its gain margin %s fails first",
                          state.found()->loops, margins.more_delay_samples,
                          margins.worst_hand.c_str());
    }
    if (ImGui::Button("save as file")) {
        state.save();
    }
    ImGui::SameLine();
    if (ImGui::Button("back to what was")) {
        if (const std::optional<Tuning> before = state.take_back()) {
            session.tune(*before);
        }
    }
}

} // namespace

void draw_stability_tab(Session &session, StabilityTabState &state) {
    state.update(session);
    if (const std::optional<Tuning> tuning = state.take_new_tuning()) {
        session.tune(*tuning);
    }
    if (state.outlook()) {
        show_outlook(session, *state.outlook());
    }
    ImGui::Separator();
    show_search(session, state);
    show_found(session, state);
}

} // namespace springdrive

#include "app/panels/look.h"
#include "app/panels/panels.h"

#include <numbers>
#include <string>

namespace springdrive {

namespace {

constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;

/// A candidate's line: what it costs and how far it is off by itself.
void draw_candidate(const ModelAxis &axis, std::size_t index, const ModelTolerance &tolerance) {
    const Candidate &candidate = axis.candidates[index];
    const bool is_chosen = index == axis.chosen;
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextColored(is_chosen ? kInk : kFaintInk, "%s %s", is_chosen ? ">" : " ",
                       candidate.name.c_str());
    ImGui::TableNextColumn();
    ImGui::TextColored(kFaintInk, "%.2f µs", 1e-3 * candidate.cost.least_ns);
    ImGui::TableNextColumn();
    ImGui::TextColored(meets(candidate.error, tolerance) ? kFaintInk : kWarning, "%.2f N, %.1f°",
                       candidate.error.force_N, candidate.error.direction_rad * kDegreesPerRadian);
}

void draw_axis(const ModelAxis &axis, const ModelTolerance &tolerance) {
    const bool is_open = ImGui::TreeNode(axis.name.c_str(), "%s: %s", axis.name.c_str(),
                                         axis.candidates[axis.chosen].name.c_str());
    if (!is_open) {
        return;
    }
    if (ImGui::BeginTable("##candidates", 3, ImGuiTableFlags_SizingStretchProp)) {
        for (std::size_t i = 0; i < axis.candidates.size(); ++i) {
            draw_candidate(axis, i, tolerance);
        }
        ImGui::EndTable();
    }
    ImGui::TreePop();
}

void draw_choice(const ModelChoice &choice, bool runs) {
    const ModelTolerance &tolerance = choice.tolerance;
    ImGui::TextColored(runs ? kInk : kFaintInk, "%s",
                       runs ? "this model runs" : "would run with --model auto");
    ImGui::TextColored(kFaintInk, "%.3f N and %.1f° off the fullest; it may %.3g N and %.3g°",
                       choice.error.force_N, choice.error.direction_rad * kDegreesPerRadian,
                       tolerance.force_N, tolerance.direction_rad * kDegreesPerRadian);
    ImGui::TextColored(kFaintInk, "%.2f µs a tick instead of %.2f µs", 1e-3 * choice.cost_ns,
                       1e-3 * choice.fullest_cost_ns);
    for (const ModelAxis &axis : choice.axes) {
        draw_axis(axis, tolerance);
    }
    for (const std::string &remark : choice.remarks) {
        ImGui::PushStyleColor(ImGuiCol_Text, kWarning);
        ImGui::TextWrapped("%s", remark.c_str());
        ImGui::PopStyleColor();
    }
}

} // namespace

void draw_model_tab(Session &session) {
    const ModelMeasurement &measurement = session.model_measurement();
    if (session.model_choice()) {
        draw_choice(*session.model_choice(), session.runs_choice());
    } else if (measurement.is_running()) {
        ImGui::TextColored(kWarning, "measuring: %s", measurement.progress().c_str());
    } else if (!measurement.error().empty()) {
        ImGui::PushStyleColor(ImGuiCol_Text, kDanger);
        ImGui::TextWrapped("%s", measurement.error().c_str());
        ImGui::PopStyleColor();
    } else {
        ImGui::TextWrapped("The cheapest model that this scene's tolerance allows is found by "
                           "measuring, which takes some seconds of one processor.");
        if (ImGui::Button("Measure")) {
            session.measure_model();
        }
    }
}

} // namespace springdrive

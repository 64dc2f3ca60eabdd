#include "app/panels/look.h"
#include "app/panels/panels.h"
#include "base/degrees.h"

#include <cstddef>
#include <string>

namespace springdrive::app {

namespace {

void explain(const char *text) {
    if (ImGui::IsItemHovered()) {
        ImGui::SetTooltip("%s", text);
    }
}

/// What is decided, for those who do not know the words.
const char *meaning_of(const std::string &axis) {
    return axis == "plant"        ? "how much of the device is simulated"
           : axis == "steps"      ? "into how many steps a servo tick of the plant is divided"
           : axis == "joints"     ? "how many of the three joints move"
           : axis == "surface"    ? "what is touched: the triangles given, fewer, or exact shapes"
           : axis == "controller" ? "how the tip's set-point becomes the motors': (18), (23)"
                                  : "an aspect that can be modelled in several ways";
}

/// Why a candidate was chosen, or not.
std::string reason_of(const model_selection::ModelAxis &axis, std::size_t index,
                      const scene::ModelTolerance &tolerance) {
    const model_selection::Candidate &candidate = axis.candidates[index];
    if (index == axis.chosen) {
        return "chosen: the cheapest with which the whole meets the scene's tolerance";
    }
    std::string reason = "by itself: " + model_selection::verdict(candidate.error, tolerance);
    for (const model_selection::CheaperTrial &trial : axis.cheaper) {
        if (trial.candidate == index) {
            reason +=
                "\nwith the rest as chosen: " + model_selection::verdict(trial.error, tolerance);
        }
    }
    return reason;
}

/// A candidate's line: what it costs and how far it is off by itself.
void draw_candidate(const model_selection::ModelAxis &axis, std::size_t index,
                    const scene::ModelTolerance &tolerance) {
    const model_selection::Candidate &candidate = axis.candidates[index];
    const bool is_chosen = index == axis.chosen;
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextColored(is_chosen ? kGood : kFaintInk, "%s%s", candidate.name.c_str(),
                       is_chosen ? ", chosen" : "");
    explain(reason_of(axis, index, tolerance).c_str());
    ImGui::TableNextColumn();
    ImGui::TextColored(kFaintInk, "%.2f µs", 1e-3 * candidate.cost.least_ns);
    ImGui::TableNextColumn();
    ImGui::TextColored(model_selection::meets(candidate.error, tolerance) ? kFaintInk : kWarning,
                       "%.2f N, %.1f°", candidate.error.force_N,
                       candidate.error.direction_rad * kDegreesPerRadian);
}

void draw_headings() {
    for (const char *heading : {"candidate", "cost of a tick", "error by itself"}) {
        ImGui::TableNextColumn();
        ImGui::TextColored(kFaintInk, "%s", heading);
        explain("cost: the least of repeated timings on this machine; error: against the fullest "
                "of\nthis aspect, all others at their fullest; orange is beyond the tolerance");
    }
}

void draw_axis(const model_selection::ModelAxis &axis, const scene::ModelTolerance &tolerance) {
    const bool is_open = ImGui::TreeNode(axis.name.c_str(), "%s: %s", axis.name.c_str(),
                                         axis.candidates[axis.chosen].name.c_str());
    explain(meaning_of(axis.name));
    if (!is_open) {
        return;
    }
    if (ImGui::BeginTable("##candidates", 3, ImGuiTableFlags_SizingStretchProp)) {
        draw_headings();
        for (std::size_t i = 0; i < axis.candidates.size(); ++i) {
            draw_candidate(axis, i, tolerance);
        }
        ImGui::EndTable();
    }
    ImGui::TreePop();
}

/// What of a planar scene's model runs: a tip that does not leave its plane is to be no riddle.
void draw_joints(const session::Session &session) {
    if (session.simulation().planar) {
        ImGui::TextWrapped("The device moves in a plane only, as this scene asks for.");
    } else if (session.scenes().now().choice.has_value() &&
               model_selection::model_of(*session.models().choice()).planar) {
        ImGui::PushStyleColor(ImGuiCol_Text, kWarning);
        ImGui::TextWrapped("All three joints move: a base that was free before is not held. Start "
                           "with this scene to simulate two.");
        ImGui::PopStyleColor();
    }
}

void draw_whether_it_runs(session::Session &session) {
    if (session.scenes().now().choice.has_value()) {
        ImGui::TextColored(kGood, "this model runs");
        return;
    }
    ImGui::TextColored(kWarning, "found, does not run yet");
    ImGui::SameLine();
    if (ImGui::SmallButton("run it")) {
        session.choose_models();
    }
    explain("loads the scene again with this model, and from now on every scene with the one\n"
            "that is chosen for it, as --model auto does. To tune, keep the full one: a model\n"
            "without mass cannot shake, whatever the gains");
}

void draw_choice(const model_selection::ModelChoice &choice) {
    const scene::ModelTolerance &tolerance = choice.tolerance;
    ImGui::TextWrapped("%.3f N and %.1f° off, %.3g N and %.3g° allowed", choice.error.force_N,
                       choice.error.direction_rad * kDegreesPerRadian, tolerance.force_N,
                       tolerance.direction_rad * kDegreesPerRadian);
    explain("against the fullest model; the scene's file states what is allowed, or else the\n"
            "usual tolerance holds");
    ImGui::TextWrapped("%.2f µs of a processor a tick, the fullest takes %.2f µs",
                       1e-3 * choice.cost_ns, 1e-3 * choice.fullest_cost_ns);
    for (const model_selection::ModelAxis &axis : choice.axes) {
        draw_axis(axis, tolerance);
    }
    for (const std::string &remark : choice.remarks) {
        ImGui::PushStyleColor(ImGuiCol_Text, kWarning);
        ImGui::TextWrapped("%s", remark.c_str());
        ImGui::PopStyleColor();
    }
}

} // namespace

void draw_model_tab(session::Session &session) {
    const session::ModelMeasurement &measurement = session.models().measurement();
    if (measurement.is_running()) {
        ImGui::TextWrapped("measuring: %s", measurement.progress().c_str());
        if (ImGui::Button("give up")) {
            session.models().give_up_measuring();
        }
        return;
    }
    if (!measurement.error().empty()) {
        ImGui::PushStyleColor(ImGuiCol_Text, kDanger);
        ImGui::TextWrapped("%s", measurement.error().c_str());
        ImGui::PopStyleColor();
    }
    if (session.models().choice()) {
        draw_whether_it_runs(session);
        draw_joints(session);
        draw_choice(*session.models().choice());
    } else {
        ImGui::TextWrapped("The cheapest model that this scene's tolerance allows is found by "
                           "measuring, which takes some seconds of one processor.");
    }
    if (ImGui::Button(session.models().choice() ? "Measure again" : "Measure")) {
        session.measure_model(session.models().choice().has_value());
    }
    explain("in the background; what was measured before on this machine is remembered");
}

} // namespace springdrive::app

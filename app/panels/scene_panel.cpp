#include "app/panels/panels.h"
#include "app/widgets/widgets.h"
#include "base/degrees.h"

#include <cstddef>
#include <string>

namespace springdrive::app {

namespace {

/// Explains an axis to users who do not know the terms.
const char *meaning_of(const std::string &axis) {
    return axis == "plant"     ? "which effects of the device are simulated"
           : axis == "steps"   ? "number of steps of the plant in a servo tick"
           : axis == "joints"  ? "how many of the three joints are simulated"
           : axis == "surface" ? "the haptic surface: the given triangles, fewer, or exact shapes"
           : axis == "controller" ? "how the tip's set-point is mapped to the motors: (18), (23)"
                                  : "an aspect that can be modelled in several ways";
}

/// Why a candidate was selected, or not.
std::string reason_of(const model_selection::ModelAxis &axis, std::size_t index,
                      const scene::ModelTolerance &tolerance) {
    const model_selection::Candidate &candidate = axis.candidates[index];
    if (index == axis.chosen) {
        return "selected: the cheapest with which the model is within the scene's tolerance";
    }
    std::string reason = "by itself: " + model_selection::verdict(candidate.error, tolerance);
    for (const model_selection::CheaperTrial &trial : axis.cheaper) {
        if (trial.candidate == index) {
            reason += "\nwith the other selected ones: " +
                      model_selection::verdict(trial.error, tolerance);
        }
    }
    return reason;
}

/// A candidate's row: its cost, and its error by itself.
void draw_candidate(const model_selection::ModelAxis &axis, std::size_t index,
                    const scene::ModelTolerance &tolerance) {
    const model_selection::Candidate &candidate = axis.candidates[index];
    const bool is_chosen = index == axis.chosen;
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ui::text(is_chosen ? kGood : kFaintInk, "{}{}", candidate.name, is_chosen ? ", selected" : "");
    ui::explain(reason_of(axis, index, tolerance));
    ImGui::TableNextColumn();
    ui::text(kFaintInk, "{:.2f} µs", 1e-3 * candidate.cost.min_ns);
    ImGui::TableNextColumn();
    ui::text(model_selection::meets(candidate.error, tolerance) ? kFaintInk : kWarning,
             "{:.2f} N, {:.1f}°", candidate.error.force_N,
             candidate.error.direction_rad * kDegreesPerRadian);
}

void draw_headings() {
    for (const char *heading : {"candidate", "cost of a tick", "error by itself"}) {
        ImGui::TableNextColumn();
        ui::text(kFaintInk, "{}", heading);
        ui::explain(
            "cost: minimum of repeated timings on this machine; error: relative to the full "
            "model,\nwith only this aspect reduced; orange is beyond the tolerance");
    }
}

void draw_axis(const model_selection::ModelAxis &axis, const scene::ModelTolerance &tolerance) {
    const std::string label = axis.name + ": " + axis.candidates[axis.chosen].name;
    const bool is_open = ImGui::TreeNode(axis.name.c_str(), "%s", label.c_str());
    ui::enter(axis.name, "tree", label, is_open);
    ui::explain(meaning_of(axis.name));
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

/// Explains why the tip does not leave its plane, or why a planar scene runs with three joints.
void draw_joints(const session::Session &session) {
    if (session.simulation().planar) {
        ui::wrapped(kInk, "The device moves only in a plane, as this scene specifies.");
    } else if (session.scenes().now().choice.has_value() &&
               model_selection::model_of(*session.models().choice()).planar) {
        ui::wrapped(kWarning, "All three joints are simulated: a base that was free is not locked. "
                              "Start with this scene to simulate two.");
    }
}

void draw_whether_it_runs(session::Session &session) {
    if (session.scenes().now().choice.has_value()) {
        ui::text(kGood, "this model is active");
        return;
    }
    ui::text(kWarning, "found, not active yet");
    ImGui::SameLine();
    if (ui::small_button("activate")) {
        session.choose_models();
    }
    ui::explain("reloads the scene with this model, and then loads every scene with the model\n"
                "selected for it, as --model auto does. For tuning keep the full model: a model\n"
                "without mass is stable with any gains");
}

void draw_choice(const model_selection::ModelSelection &choice) {
    const scene::ModelTolerance &tolerance = choice.tolerance;
    ui::wrapped(kInk, "error {:.3f} N and {:.1f}°, tolerance {:.3g} N and {:.3g}°",
                choice.error.force_N, choice.error.direction_rad * kDegreesPerRadian,
                tolerance.force_N, tolerance.direction_rad * kDegreesPerRadian);
    ui::explain(
        "relative to the full model; the tolerance is that of the scene's file, or else the\n"
        "default");
    ui::wrapped(kInk, "{:.2f} µs of computing time per tick, full model {:.2f} µs",
                1e-3 * choice.cost_ns, 1e-3 * choice.fullest_cost_ns);
    for (const model_selection::ModelAxis &axis : choice.axes) {
        draw_axis(axis, tolerance);
    }
    for (const std::string &warning : choice.warnings) {
        ui::wrapped(kWarning, "{}", warning);
    }
}

void draw_file_list(session::Session &session, const ScenePanelState &state) {
    const std::filesystem::path &shown = session.scenes().now().scene.file;
    ImGui::SetNextItemWidth(-1.0F);
    const ui::DropDown list("##files", shown.filename().c_str());
    if (!list) {
        return;
    }
    for (const std::filesystem::path &file : state.files) {
        if (ui::selectable(file.filename().c_str(), file == shown)) {
            session.request_scene(file);
        }
    }
}

void draw_scene_tab(session::Session &session, ScenePanelState &state) {
    const session::LoadedScene &shown = session.scenes().now();
    draw_file_list(session, state);
    ImGui::SetNextItemWidth(-1.0F);
    if (ui::text_field("##path", "path of a glTF file, or drop one here", state.typed)) {
        session.request_scene(state.typed);
    }
    if (session.scenes().is_loading()) {
        ui::wrapped(kWarning, "loading: {}", session.scenes().progress());
    } else {
        ui::show_error(session.scenes().error());
    }
    if (state.card.is_put_away && ui::small_button("what to feel")) {
        state.card.is_put_away = false;
    }
    const Vector3 size_mm = 1000.0 * (shown.scene.upper_m - shown.scene.lower_m);
    ui::text(kInk, "{} triangles to touch, {:.0f} × {:.0f} × {:.0f} mm",
             shown.scene.surface.triangles.size(), size_mm.x(), size_mm.y(), size_mm.z());
    if (shown.scene.in_metres) {
        ui::text(kFaintInk, "scale: 1 unit = 1 m, by the file");
    } else {
        ui::text(kFaintInk, "scale: 1 unit = {:.4g} mm, fitted to the workspace",
                 1000.0 * shown.scene.metres_per_unit);
    }
    if (session.simulation().planar) {
        ui::text(kFaintInk, "planar: the tip stays in the linkage's plane");
    }
    for (const std::string &warning : shown.scene.warnings) {
        ui::wrapped(kWarning, "{}", warning);
    }
}

/// The model selected by the scene's tolerance, and the active model.
void draw_model_tab(session::Session &session) {
    const session::ModelMeasurement &measurement = session.models().measurement();
    if (measurement.is_running()) {
        ui::wrapped(kInk, "measuring: {}", measurement.progress());
        if (ui::button("cancel")) {
            session.models().give_up_measuring();
        }
        return;
    }
    ui::show_error(measurement.error());
    if (session.models().choice()) {
        draw_whether_it_runs(session);
        draw_joints(session);
        draw_choice(*session.models().choice());
    } else {
        ui::wrapped(kInk, "The cheapest model within this scene's tolerance is found by measuring, "
                          "which takes some seconds on one processor.");
    }
    if (ui::button(session.models().choice() ? "Measure again" : "Measure")) {
        session.measure_model(session.models().choice().has_value());
    }
    ui::explain("in the background; earlier results on this machine are cached");
}

} // namespace

void draw_scene_panel(session::Session &session, TuningEditor &editor, OpenedRecord &opened,
                      ScenePanelState &state, const Rectangle &place) {
    const ui::Panel panel("Scene", place, ImGuiWindowFlags_NoTitleBar);
    const ui::Tabs tabs("##tabs");
    if (!tabs) {
        return;
    }
    if (const ui::Tab contents("Scene"); contents) {
        draw_scene_tab(session, state);
    }
    if (const ui::Tab hand("Hand"); hand) {
        draw_hand_tab(session, state.hand);
    }
    if (const ui::Tab plant("Plant"); plant) {
        draw_plant_tab(session, state.plant);
    }
    if (const ui::Tab model("Model"); model) {
        draw_model_tab(session);
    }
    if (const ui::Tab record("Record"); record) {
        draw_record_tab(session, editor, opened, state.record);
    }
}

} // namespace springdrive::app

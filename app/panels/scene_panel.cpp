#include "app/panels/panels.h"
#include "app/widgets/widgets.h"

namespace springdrive::app {

namespace {

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
    } else if (!session.scenes().error().empty()) {
        ui::wrapped(kDanger, "{}", session.scenes().error());
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

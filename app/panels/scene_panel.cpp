#include "app/panels/look.h"
#include "app/panels/panels.h"

#include <imgui_stdlib.h>

namespace springdrive::app {

namespace {

void draw_scene_tab(session::Session &session, ScenePanelState &state) {
    const session::LoadedScene &shown = session.scenes().now();
    ImGui::SetNextItemWidth(-1.0F);
    if (ImGui::BeginCombo("##files", shown.scene.file.filename().c_str())) {
        for (const std::filesystem::path &file : state.files) {
            if (ImGui::Selectable(file.filename().c_str(), file == shown.scene.file)) {
                session.request_scene(file);
            }
        }
        ImGui::EndCombo();
    }
    ImGui::SetNextItemWidth(-1.0F);
    if (ImGui::InputTextWithHint("##path", "path of a glTF file, or drop one here", &state.typed,
                                 ImGuiInputTextFlags_EnterReturnsTrue)) {
        session.request_scene(state.typed);
    }
    if (session.scenes().is_loading()) {
        ImGui::PushStyleColor(ImGuiCol_Text, kWarning);
        ImGui::TextWrapped("loading: %s", session.scenes().progress().c_str());
        ImGui::PopStyleColor();
    } else if (!session.scenes().error().empty()) {
        ImGui::PushStyleColor(ImGuiCol_Text, kDanger);
        ImGui::TextWrapped("%s", session.scenes().error().c_str());
        ImGui::PopStyleColor();
    }
    const Vector3 size_mm = 1000.0 * (shown.scene.upper_m - shown.scene.lower_m);
    ImGui::Text("%zu triangles, %.0f × %.0f × %.0f mm", shown.scene.surface.triangles.size(),
                size_mm.x(), size_mm.y(), size_mm.z());
    if (shown.scene.in_metres) {
        ImGui::TextColored(kFaintInk, "scale: 1 unit = 1 m, by the file");
    } else {
        ImGui::TextColored(kFaintInk, "scale: 1 unit = %.4g mm, fitted to the workspace",
                           1000.0 * shown.scene.metres_per_unit);
    }
    if (session.simulation().planar) {
        ImGui::TextColored(kFaintInk, "planar: the tip stays in the linkage's plane");
    }
    for (const std::string &remark : shown.scene.remarks) {
        ImGui::PushStyleColor(ImGuiCol_Text, kWarning);
        ImGui::TextWrapped("%s", remark.c_str());
        ImGui::PopStyleColor();
    }
}

} // namespace

void draw_scene_panel(session::Session &session, ScenePanelState &state, const Rectangle &place) {
    begin_panel("Scene", place);
    if (ImGui::BeginTabBar("##tabs")) {
        if (ImGui::BeginTabItem("Contents")) {
            draw_scene_tab(session, state);
            ImGui::EndTabItem();
        }
        if (ImGui::BeginTabItem("Model")) {
            draw_model_tab(session);
            ImGui::EndTabItem();
        }
        ImGui::EndTabBar();
    }
    ImGui::End();
}

} // namespace springdrive::app

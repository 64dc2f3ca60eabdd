#include "app/panels/look.h"
#include "app/panels/panels.h"

#include <algorithm>

namespace springdrive::app {

namespace {

void draw_trip_banner(session::Session &session, const Rectangle &view, float scale) {
    const servo::SafetyStatus &safety = session.latest().safety;
    const float width = std::min(0.9F * view.size.x, 520.0F * scale);
    ImGui::SetNextWindowPos({view.corner.x + 0.5F * (view.size.x - width), 16.0F * scale});
    ImGui::SetNextWindowSize({width, 0.0F});
    ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.42F, 0.09F, 0.08F, 0.96F));
    ImGui::Begin("stopped", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing);
    ImGui::TextWrapped("Stopped: %s. The motors brake.", servo::description(safety).c_str());
    if (!servo::is_final(safety.cause) && ImGui::Button("Reset")) {
        session.servo().reset_safety();
    }
    ImGui::End();
    ImGui::PopStyleColor();
}

} // namespace

void draw_scene_overlay(session::Session &session, const Rectangle &view, float scale) {
    if (session.latest().safety.state == servo::SafetyState::tripped) {
        draw_trip_banner(session, view, scale);
    }
    const char *help = session.hand().follows_path()
                           ? "the hand follows a path · right drag: orbit · middle drag: pan · "
                             "wheel: zoom · space: emergency stop"
                           : "left drag: move the hand, with the wheel: depth · right drag: orbit "
                             "· middle drag: pan · wheel: zoom · space: emergency stop";
    ImDrawList &list = *ImGui::GetBackgroundDrawList();
    const float margin = 10.0F * scale;
    const float wrap = view.size.x - 2.0F * margin;
    const float height = ImGui::CalcTextSize(help, nullptr, false, wrap).y;
    const ImVec2 corner{view.corner.x + margin, view.corner.y + view.size.y - height - margin};
    list.PushClipRect(view.corner, {view.corner.x + view.size.x, view.corner.y + view.size.y});
    list.AddText(ImGui::GetFont(), ImGui::GetFontSize(), corner,
                 ImGui::ColorConvertFloat4ToU32({0.75F, 0.78F, 0.82F, 0.9F}), help, nullptr, wrap);
    list.PopClipRect();
}

} // namespace springdrive::app

#include "app/widgets/look.h"

namespace springdrive::app {

void apply_look(float scale) {
    ImGuiStyle &style = ImGui::GetStyle();
    style = ImGuiStyle();
    ImGui::StyleColorsDark();
    style.WindowRounding = 0.0F;
    style.WindowBorderSize = 1.0F;
    style.FrameRounding = 4.0F;
    style.GrabRounding = 4.0F;
    style.GrabMinSize = 12.0F;
    style.ScrollbarSize = 9.0F;
    style.WindowPadding = ImVec2(10.0F, 8.0F);
    style.FramePadding = ImVec2(6.0F, 2.0F);
    style.ItemSpacing = ImVec2(7.0F, 4.0F);
    style.ScaleAllSizes(scale);

    ImVec4 *colours = style.Colors;
    colours[ImGuiCol_Text] = kInk;
    colours[ImGuiCol_WindowBg] = ImVec4(0.115F, 0.127F, 0.15F, 1.0F);
    colours[ImGuiCol_PopupBg] = ImVec4(0.14F, 0.155F, 0.18F, 1.0F);
    colours[ImGuiCol_Border] = ImVec4(0.24F, 0.27F, 0.31F, 1.0F);
    colours[ImGuiCol_TitleBg] = ImVec4(0.16F, 0.18F, 0.215F, 1.0F);
    colours[ImGuiCol_TitleBgActive] = colours[ImGuiCol_TitleBg];
    colours[ImGuiCol_FrameBg] = ImVec4(0.20F, 0.225F, 0.265F, 1.0F);
    colours[ImGuiCol_FrameBgHovered] = ImVec4(0.25F, 0.285F, 0.335F, 1.0F);
    colours[ImGuiCol_FrameBgActive] = ImVec4(0.28F, 0.32F, 0.38F, 1.0F);
    colours[ImGuiCol_SliderGrab] = ImVec4(0.33F, 0.62F, 0.93F, 1.0F);
    colours[ImGuiCol_SliderGrabActive] = ImVec4(0.47F, 0.74F, 1.0F, 1.0F);
    colours[ImGuiCol_Button] = ImVec4(0.22F, 0.29F, 0.38F, 1.0F);
    colours[ImGuiCol_ButtonHovered] = ImVec4(0.28F, 0.38F, 0.51F, 1.0F);
    colours[ImGuiCol_ButtonActive] = ImVec4(0.33F, 0.46F, 0.62F, 1.0F);
    colours[ImGuiCol_Header] = ImVec4(0.22F, 0.29F, 0.38F, 1.0F);
    colours[ImGuiCol_HeaderHovered] = ImVec4(0.28F, 0.38F, 0.51F, 1.0F);
    colours[ImGuiCol_CheckMark] = colours[ImGuiCol_SliderGrab];
}

} // namespace springdrive::app

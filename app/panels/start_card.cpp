#include "app/panels/panels.h"
#include "app/widgets/widgets.h"

#include <array>

namespace springdrive::app {

namespace {

struct StartLine {
    const char *about;
    const char *text;
};

/// Short enough for one line each in the smallest window; true of every scene.
constexpr std::array<StartLine, 3> kStartLines{{
    {"Simulated", "a PHANTOM with its motors, and a hand. No device is attached."},
    {"Move the hand", "press where it is to touch, drag to slide. Beside the scene: a free drag."},
    {"Try first", "press on the surface: the arrow is the force. M: the other map may tilt it."},
}};

} // namespace

StartAnswer draw_start_card(const Rectangle &place, float &height) {
    StartAnswer answer = StartAnswer::none;
    ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.10F, 0.20F, 0.36F, 1.0F));
    {
        const ui::Panel panel("Start", place,
                              ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoScrollbar |
                                  ImGuiWindowFlags_NoFocusOnAppearing);
        const float texts_at = 8.0F * ImGui::GetFontSize();
        for (const StartLine &line : kStartLines) {
            ui::text(kForce, "{}", line.about);
            ImGui::SameLine(texts_at);
            ui::wrapped(kInk, "{}", line.text);
        }
        if (ui::button("got it")) {
            answer = StartAnswer::got_it;
        }
        ui::explain("does not show this again; reset the settings in the menu \u2261 to see it");
        ImGui::SameLine();
        if (ui::button("keys  F1")) {
            answer = StartAnswer::keys;
        }
        ImGui::SameLine();
        if (ui::button("the wrong direction")) {
            answer = StartAnswer::wrong_direction;
        }
        ui::explain("Shows the scene in which M tilts it most: press on the orange square there.");
        height = ImGui::GetCursorPosY() - ImGui::GetStyle().ItemSpacing.y +
                 ImGui::GetStyle().WindowPadding.y;
    }
    ImGui::PopStyleColor();
    return answer;
}

} // namespace springdrive::app

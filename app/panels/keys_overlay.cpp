#include "app/panels/panels.h"
#include "app/widgets/widgets.h"

#include <array>

namespace springdrive::app {

namespace {

struct KeyHelp {
    const char *key;
    const char *what;
};

/// All keys of the window; those without Ctrl act while no text is typed, F12 always.
constexpr std::array<KeyHelp, 29> kKeys{{
    {"F12", "emergency stop, at any time; the space bar while no text is typed"},
    {"Ctrl+Z", "take the last change of the tuning back"},
    {"Ctrl+Y", "do it again; also Ctrl+Shift+Z"},
    {"Ctrl+S", "keep the session in a folder, or bring it up to date"},
    {"B", "switch between the tunings A and B"},
    {"M", "switch between the maps"},
    {"H", "hold the plots, or follow the present"},
    {"+ -, PgUp PgDn", "zoom the plots in time; move them to earlier or later"},
    {"P", "pause the simulated device, or go on; a record that is shown, too"},
    {". ,", "one tick of the paused device, or of the record: on, back"},
    {"R", "show the record that is open, or the present"},
    {"W A S D Q E", "move the hand: forward, left, back, right, down, up; with Shift finely"},
    {"I J K L U O", "turn the view: up, left, down, right; nearer, farther"},
    {"F6", "go to the next panel; with Shift, to the one before"},
    {"arrows, Tab", "go from widget to widget; Enter presses it, or begins to change it"},
    {"Home", "show the whole device and scene, also after the window has changed"},
    {"T F", "the same from above, from the front"},
    {"F9", "write a picture of the window, where sessions are kept"},
    {"F10", "hide the panels, or show them: scene and read-outs alone"},
    {"F11", "fill the screen"},
    {"Ctrl + − 0", "larger, smaller, usual text"},
    {"F1", "show or hide these keys"},
    {"Esc", "close what is open: this, a list, large plots, the full screen"},
    {"wheel on a plot", "zoom in time; with Ctrl, in value"},
    {"drag on a plot", "move; with the right button, zoom to the range"},
    {"double click on a plot", "live again, with its own ranges"},
    {"left press on the scene", "touch there; a drag slides on it, the wheel presses deeper"},
    {"left drag beside it", "move the hand, also with Shift; with the wheel, in depth"},
    {"right or middle drag", "turn or shift the view; the wheel zooms to the cursor"},
}};

} // namespace

void draw_keys_overlay(const Rectangle &window) {
    const float font = ImGui::GetFontSize();
    const ui::Scope scope("keys");
    ImGui::SetNextWindowPos(
        {window.corner.x + 0.5F * window.size.x, window.corner.y + 0.5F * window.size.y},
        ImGuiCond_Always, {0.5F, 0.5F});
    ImGui::Begin("keys", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoInputs |
                     ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings);
    ui::text(kInk, "Keys and mouse");
    ImGui::Separator();
    for (const KeyHelp &help : kKeys) {
        ui::text(kForce, "{}", help.key);
        ImGui::SameLine(12.0F * font);
        ui::text(kInk, "{}", help.what);
    }
    ImGui::End();
}

} // namespace springdrive::app

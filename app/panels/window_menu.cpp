#include "app/panels/panels.h"
#include "app/widgets/widgets.h"

#include <array>
#include <string>
#include <system_error>

namespace springdrive::app {

namespace {

struct MenuEntry {
    WindowOrder order;
    const char *label;
    const char *key;
};

constexpr std::array<MenuEntry, 9> kMenuEntries{{
    {WindowOrder::tour, "tour of the scenes", ""},
    {WindowOrder::toggle_panels, "hide or show the panels", "F10"},
    {WindowOrder::toggle_full_screen, "fill the screen", "F11"},
    {WindowOrder::larger_text, "larger text", "Ctrl +"},
    {WindowOrder::smaller_text, "smaller text", "Ctrl −"},
    {WindowOrder::usual_text, "usual text", "Ctrl 0"},
    {WindowOrder::take_picture, "picture of the window", "F9"},
    {WindowOrder::toggle_keys, "keys and mouse", "F1"},
    {WindowOrder::reset, "reset the settings", ""},
}};

void draw_recent(const Settings &settings, WindowMenuChoice &choice) {
    if (settings.recent.empty()) {
        return;
    }
    ImGui::Separator();
    ui::text(kFaintInk, "recent files");
    const ui::Scope scope("recent");
    for (const std::filesystem::path &file : settings.recent) {
        std::error_code ignored;
        const bool is_there = std::filesystem::exists(file, ignored);
        {
            const ui::Disabled gone(!is_there);
            const ui::Scope one(file.string());
            if (ui::selectable(file.filename().c_str(), false)) {
                choice.opened = file;
            }
        }
        ui::explain(file.string() + (is_there ? "" : "\nis not there any more"));
    }
}

} // namespace

WindowMenuChoice draw_window_menu(const WindowHabits &habits, const Rectangle &view, float scale) {
    WindowMenuChoice choice;
    const float margin = 10.0F * scale;
    const ui::Scope scope("window");
    ImGui::SetNextWindowPos({view.corner.x + margin, view.corner.y + margin});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.0F, 0.0F});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0.0F);
    ImGui::Begin("window", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoBackground |
                     ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_AlwaysAutoResize);
    const float side = 2.0F * ImGui::GetFontSize();
    const bool is_pressed = ui::button("≡##menu", {side, side});
    ui::explain("the window: text, panels, full screen, pictures, recent files");
    ImGui::PopStyleVar(2);
    if (is_pressed) {
        ImGui::OpenPopup("menu");
    }
    if (ImGui::BeginPopup("menu")) {
        const float keys_at = 14.0F * ImGui::GetFontSize();
        for (const MenuEntry &entry : kMenuEntries) {
            const bool forgets = entry.order == WindowOrder::reset;
            if (forgets && !habits.remembers()) {
                continue;
            }
            if (ui::selectable(entry.label, false)) {
                choice.order = entry.order;
            }
            if (forgets) {
                ui::explain("size and text of the window, panels, recent files and the first "
                            "minute's plate:\nall as in a first run");
            }
            if (*entry.key != '\0') {
                ImGui::SameLine(keys_at);
                ui::text(kFaintInk, "{}", entry.key);
            }
        }
        draw_recent(habits.settings(), choice);
        ImGui::EndPopup();
    }
    ImGui::End();
    return choice;
}

} // namespace springdrive::app

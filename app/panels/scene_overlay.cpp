#include "app/panels/panels.h"
#include "app/widgets/widgets.h"
#include "base/one_line.h"

#include <algorithm>
#include <array>

namespace springdrive::app {

namespace {

constexpr const char *kHandHelp =
    "left drag: move the hand, with the wheel: depth · right drag: orbit · middle drag: pan · "
    "wheel: zoom to the cursor · F1: keys";
constexpr const char *kPathHelp =
    "the hand follows a path · right drag: orbit · middle drag: pan · wheel: zoom to the cursor · "
    "F1: keys";

/// Of what stands over the scene, to its edges.
float margin(float scale) { return 10.0F * scale; }

/// Broken into lines as it is drawn.
ImVec2 help_size(const char *help, const Rectangle &view, float scale) {
    const float wrap = view.size.x - 2.0F * margin(scale);
    return {wrap, ImGui::CalcTextSize(help, nullptr, false, wrap).y};
}

float width_of_view_buttons() {
    return ImGui::CalcTextSize("front").x + 2.0F * ImGui::GetStyle().FramePadding.x;
}

/// A box over the top of the scene, in a colour that says how urgent it is.
class Banner {
public:
    Banner(const char *name, const Rectangle &view, float scale, const ImVec4 &colour)
        : scope_(name) {
        const float width =
            std::min(0.9F * view.size.x - 2.0F * room_of_stop(scale), 480.0F * scale);
        ImGui::SetNextWindowPos({view.corner.x + 0.5F * (view.size.x - width), kTop * scale});
        ImGui::SetNextWindowSize({width, 0.0F});
        ImGui::PushStyleColor(ImGuiCol_WindowBg, colour);
        ImGui::Begin(name, nullptr, kOverlay);
    }
    ~Banner() {
        ImGui::End();
        ImGui::PopStyleColor();
    }
    Banner(const Banner &) = delete;
    Banner &operator=(const Banner &) = delete;

    static constexpr ImGuiWindowFlags kOverlay =
        ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
        ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing;

    static constexpr float kTop = 12.0F; ///< below the scene's upper edge, times the scale

    /// Width beside the banner for the button that stops.
    [[nodiscard]] static float room_of_stop(float scale) { return 100.0F * scale; }

private:
    ui::Scope scope_;
};

void draw_trip_banner(session::Session &session, const Rectangle &view, float scale) {
    const servo::SafetyStatus &safety = session.latest().safety;
    const Banner banner("stopped", view, scale, ImVec4(0.42F, 0.09F, 0.08F, 0.96F));
    ui::wrapped(kInk, "Stopped: {}. The motors brake.", servo::description(safety));
    if (!servo::is_final(safety.cause) && ui::button("Reset")) {
        session.servo().reset_safety();
    }
}

/// What has to happen before the motors start: otherwise a reset seems to do nothing.
void draw_waiting_banner(const session::Session &session, const Rectangle &view, float scale) {
    const Banner banner("waiting", view, scale, ImVec4(0.36F, 0.26F, 0.05F, 0.96F));
    ui::wrapped(kInk, "{}",
                session.is_lent() ? "A step of the assistant has the device: its motors may act."
                : session.is_kept_released() ? "The device only brakes."
                : session.latest().contact.touching
                    ? "The motors brake until the tip is lifted off the surface and held still."
                    : "The motors start as soon as the tip is held still.");
}

/// So that a record is not taken for the present.
void draw_record_banner(const session::Session &session, const OpenedRecord &opened,
                        const Rectangle &view, float scale) {
    const Banner banner("record shown", view, scale, ImVec4(0.10F, 0.20F, 0.36F, 0.96F));
    const session::LoadedRecord &record = opened.playback().record();
    ui::wrapped(kInk, "Record: {}. The servo goes on; R shows the present.",
                record.file.filename().string());
    const session::RecordedScene then = record.scene_of(opened.playback().sample());
    if (then.sha256 != session.scenes().now().sha256) {
        ui::wrapped(kWarning, "Not its scene: it was recorded on {}.",
                    in_quotes(std::filesystem::path(then.file).filename().string()));
    }
}

void draw_stop_button(session::Session &session, const Rectangle &view, float scale) {
    const float width = Banner::room_of_stop(scale) - margin(scale);
    const ui::Scope scope("stop");
    ImGui::SetNextWindowPos(
        {view.corner.x + view.size.x - width - margin(scale), view.corner.y + margin(scale)});
    ImGui::SetNextWindowSize({width, 0.0F});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.0F, 0.0F});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0.0F);
    ImGui::PushStyleColor(ImGuiCol_Button, ImVec4(0.66F, 0.12F, 0.10F, 1.0F));
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, ImVec4(0.80F, 0.17F, 0.14F, 1.0F));
    ImGui::PushStyleColor(ImGuiCol_ButtonActive, ImVec4(0.92F, 0.24F, 0.20F, 1.0F));
    ImGui::Begin("stop", nullptr,
                 Banner::kOverlay | ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_NoNav);
    if (ui::button("STOP  F12", {width, 2.0F * ImGui::GetFontSize()})) {
        session.servo().emergency_stop();
    }
    ui::explain("Emergency stop: the motors brake at once. F12 does the same at any time, and the\n"
                "space bar while no text is typed.");
    ImGui::End();
    ImGui::PopStyleColor(3);
    ImGui::PopStyleVar(2);
}

} // namespace

void draw_scene_overlay(session::Session &session, OpenedRecord &opened, const Rectangle &view,
                        float scale) {
    const bool is_record = opened.is_shown();
    switch (session.latest().safety.state) {
    case servo::SafetyState::tripped:
        draw_trip_banner(session, view, scale);
        break;
    case servo::SafetyState::waiting:
        if (!is_record) {
            draw_waiting_banner(session, view, scale);
        }
        break;
    default:
        break;
    }
    draw_stop_button(session, view, scale);
    if (is_record) {
        if (session.latest().safety.state != servo::SafetyState::tripped) {
            draw_record_banner(session, opened, view, scale);
        }
        draw_record_controls(opened, view, scale);
        return;
    }
    const char *const help = session.hand().follows_path() ? kPathHelp : kHandHelp;
    const ImVec2 size = help_size(help, view, scale);
    const ImVec2 corner{view.corner.x + margin(scale),
                        view.corner.y + view.size.y - size.y - margin(scale)};
    ImDrawList &list = *ImGui::GetBackgroundDrawList();
    list.PushClipRect(view.corner, {view.corner.x + view.size.x, view.corner.y + view.size.y});
    list.AddText(ImGui::GetFont(), ImGui::GetFontSize(), corner,
                 ImGui::ColorConvertFloat4ToU32({0.75F, 0.78F, 0.82F, 0.9F}), help, nullptr,
                 size.x);
    list.PopClipRect();
    ui::enter_at({corner, size}, "help", "text", help);
}

std::optional<Viewpoint> draw_view_buttons(const Rectangle &view, float scale) {
    struct Choice {
        const char *label;
        Viewpoint viewpoint;
        const char *help;
    };
    constexpr std::array<Choice, 3> kChoices{
        {{"home", Viewpoint::home, "Shows all of device and scene; key Home."},
         {"top", Viewpoint::top, "The same from above; key T."},
         {"front", Viewpoint::front, "The same from the front, level; key F."}}};
    const ui::Scope scope("view");
    ImGui::SetNextWindowPos({view.corner.x + margin(scale), view.corner.y + margin(scale)});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.0F, 0.0F});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0.0F);
    ImGui::Begin("view", nullptr,
                 Banner::kOverlay | ImGuiWindowFlags_NoBackground |
                     ImGuiWindowFlags_AlwaysAutoResize);
    std::optional<Viewpoint> chosen;
    for (const Choice &choice : kChoices) {
        if (ui::button(choice.label, {width_of_view_buttons(), 0.0F})) {
            chosen = choice.viewpoint;
        }
        ui::explain(choice.help);
    }
    ImGui::End();
    ImGui::PopStyleVar(2);
    return chosen;
}

Rectangle free_of_overlays(const Rectangle &view, bool is_record, float scale) {
    const float left = width_of_view_buttons() + 2.0F * margin(scale);
    const float right = 2.0F * margin(scale);
    const float top = Banner::kTop * scale + ImGui::GetTextLineHeight() +
                      2.0F * ImGui::GetStyle().WindowPadding.y + margin(scale);
    const float bottom =
        2.0F * margin(scale) +
        (is_record ? ImGui::GetFrameHeight() + 1.4F * ImGui::GetStyle().WindowPadding.y
                   : help_size(kHandHelp, view, scale).y);
    const Rectangle free{{view.corner.x + left, view.corner.y + top},
                         {view.size.x - left - right, view.size.y - top - bottom}};
    const bool has_room = free.size.x > 0.5F * view.size.x && free.size.y > 0.5F * view.size.y;
    return has_room ? free : view;
}

} // namespace springdrive::app

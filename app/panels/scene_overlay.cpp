#include "app/panels/scene_overlay.h"

#include "app/widgets/widgets.h"
#include "base/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace springdrive::app {

namespace {

SceneMessage stopped(const SceneSituation &now) {
    SceneMessage message{
        "stopped", SceneUrgency::stopped,
        fmt::format("Stopped: {}. The motors brake.", servo::description(now.safety))};
    if (now.is_lost) {
        message.more = now.reconnects ? "No device: plug it in, it is connected again by itself."
                                      : "No device: connect it again in the tab Plant.";
        return message; // a reset would trip at once
    }
    if (servo::is_final(now.safety.cause)) {
        message.more = "Start springdrive again: no reset clears this.";
        return message;
    }
    message.button = "Reset";
    message.action = SceneAction::reset;
    return message;
}

SceneMessage record_shown(const SceneSituation &now) {
    SceneMessage message{"record shown", SceneUrgency::hint,
                         fmt::format("Record: {}. The servo goes on.", now.record)};
    if (!now.scene_of_record.empty()) {
        message.more = fmt::format("Not its scene: it was recorded on {}.", now.scene_of_record);
    }
    message.button = "show the present  R";
    message.action = SceneAction::show_present;
    return message;
}

/// A button only where the hand is ours to move.
SceneMessage with_lift(SceneMessage message, const SceneSituation &now, const char *button) {
    if (now.can_move_hand) {
        message.button = button;
        message.action = SceneAction::retract_hand;
    }
    return message;
}

/// What has to happen before the motors start: otherwise a reset seems to do nothing.
SceneMessage waiting(const SceneSituation &now) {
    if (now.is_in_exclusive_use) {
        return {"waiting", SceneUrgency::waits,
                "A step of the assistant has the device: its motors may act."};
    }
    if (now.is_released) {
        return {"waiting", SceneUrgency::waits, "The device only brakes.",
                "The assistant holds it."};
    }
    if (!now.is_zeroed) {
        return {"waiting",
                SceneUrgency::waits,
                "The board does not know where the device is.",
                "Hold the upper arm level and the forearm hanging, then:",
                "zero here",
                SceneAction::zero};
    }
    if (now.touching) {
        return with_lift({"waiting", SceneUrgency::waits, "Lift the tip to start.",
                          "The motors brake until the tip is lifted off the surface and held "
                          "still."},
                         now, "lift the tip");
    }
    return {"waiting", SceneUrgency::waits, "The motors start as soon as the tip is held still."};
}

constexpr const char *kHandHelp =
    "left press on the scene: touch there, drag: slide · beside it, or with Shift: move the hand · "
    "meanwhile the wheel: depth · right drag: orbit · middle drag: pan · wheel: zoom · F1: keys";
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

float height_of_stop() { return 2.0F * ImGui::GetFontSize(); }

constexpr ImGuiWindowFlags kOverlay = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                      ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                                      ImGuiWindowFlags_NoFocusOnAppearing;

/// Width beside a message for the button that stops, and on the other side for the menu.
float room_of_stop(float scale) { return 100.0F * scale; }

/// Dark enough for white letters, and opaque: it must be read over any mesh.
ImVec4 colour_of(SceneUrgency urgency) {
    switch (urgency) {
    case SceneUrgency::stopped:
        return {0.42F, 0.09F, 0.08F, 0.97F};
    case SceneUrgency::waits:
        return {0.36F, 0.26F, 0.05F, 0.97F};
    case SceneUrgency::hint:
        break;
    }
    return {0.10F, 0.20F, 0.36F, 0.97F};
}

constexpr float kMessageFont = 1.2F; ///< times the plain text's

/// A plate over the top of the scene, the button beside the text: as low as can be, since below it
/// stands the device's head.
/// @param bottom  of it
SceneAction draw_message(const SceneMessage &message, const Rectangle &view, float scale,
                         float &bottom) {
    const ui::Scope scope(message.name);
    const float width = std::min(0.95F * view.size.x - 2.0F * room_of_stop(scale), 620.0F * scale);
    ImGui::SetNextWindowPos(
        {view.corner.x + 0.5F * (view.size.x - width), view.corner.y + margin(scale)});
    ImGui::SetNextWindowSize({width, 0.0F});
    ImGui::PushStyleColor(ImGuiCol_WindowBg, colour_of(message.urgency));
    ImGui::Begin("message", nullptr, kOverlay);
    const bool has_button = *message.button != '\0';
    bool is_pressed = false;
    if (ImGui::BeginTable("row", has_button ? 2 : 1)) {
        ImGui::TableSetupColumn("text", ImGuiTableColumnFlags_WidthStretch);
        if (has_button) {
            ImGui::TableSetupColumn("button", ImGuiTableColumnFlags_WidthFixed);
        }
        ImGui::TableNextColumn();
        ImGui::SetWindowFontScale(kMessageFont);
        ui::wrapped(kInk, "{}", message.text);
        ImGui::SetWindowFontScale(1.0F);
        if (!message.more.empty()) {
            ui::wrapped(kInk, "{}", message.more);
        }
        if (has_button) {
            ImGui::TableNextColumn();
            is_pressed = ui::button(message.button);
        }
        ImGui::EndTable();
    }
    bottom = ImGui::GetWindowPos().y + ImGui::GetWindowSize().y;
    ImGui::End();
    ImGui::PopStyleColor();
    return is_pressed ? message.action : SceneAction::none;
}

/// On a plate above the help, in the corner where neither read-outs nor messages are.
void draw_notice(const Notice &notice, const Rectangle &view, float scale) {
    const ui::Scope scope("notice");
    const float requested = ImGui::CalcTextSize(notice.text.c_str()).x + 3.0F * margin(scale);
    ImGui::SetNextWindowPos({view.end().x - margin(scale), view.end().y - 3.5F * margin(scale)},
                            ImGuiCond_Always, {1.0F, 1.0F});
    ImGui::SetNextWindowSize({std::min(0.55F * view.size.x, requested), 0.0F});
    ImGui::PushStyleColor(ImGuiCol_WindowBg,
                          colour_of(notice.is_bad ? SceneUrgency::stopped : SceneUrgency::hint));
    ImGui::Begin("notice", nullptr, kOverlay | ImGuiWindowFlags_NoInputs);
    ui::wrapped(kInk, "{}", notice.text);
    ImGui::End();
    ImGui::PopStyleColor();
}

void draw_stop_button(session::Session &session, const Rectangle &view, float scale) {
    const float width = room_of_stop(scale) - margin(scale);
    const ui::Scope scope("stop");
    ImGui::SetNextWindowPos({view.end().x - width - margin(scale), view.corner.y + margin(scale)});
    ImGui::SetNextWindowSize({width, 0.0F});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.0F, 0.0F});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0.0F);
    ImGui::PushStyleColor(ImGuiCol_Button, ImVec4(0.66F, 0.12F, 0.10F, 1.0F));
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, ImVec4(0.80F, 0.17F, 0.14F, 1.0F));
    ImGui::PushStyleColor(ImGuiCol_ButtonActive, ImVec4(0.92F, 0.24F, 0.20F, 1.0F));
    ImGui::Begin("stop", nullptr,
                 kOverlay | ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_NoNav);
    if (ui::button("STOP  F12", {width, height_of_stop()})) {
        session.emergency_stop();
    }
    ui::explain("Emergency stop: the motors brake at once. F12 does the same at any time, and the\n"
                "space bar while no text is typed.");
    ImGui::End();
    ImGui::PopStyleColor(3);
    ImGui::PopStyleVar(2);
}

/// @return its upper edge
float draw_help(const session::Session &session, const Rectangle &view, float scale) {
    const char *const help = session.hand().follows_path() ? kPathHelp : kHandHelp;
    const ImVec2 size = help_size(help, view, scale);
    const ImVec2 corner{view.corner.x + margin(scale), view.end().y - size.y - margin(scale)};
    ImDrawList &list = *ImGui::GetBackgroundDrawList();
    list.PushClipRect(view.corner, view.end());
    const ImVec2 text = ImGui::CalcTextSize(help, nullptr, false, size.x);
    const ImVec2 around{0.6F * margin(scale), 0.3F * margin(scale)};
    list.AddRectFilled({corner.x - around.x, corner.y - around.y},
                       {corner.x + text.x + around.x, corner.y + text.y + around.y},
                       ImGui::ColorConvertFloat4ToU32({0.07F, 0.08F, 0.10F, 0.80F}), 3.0F * scale);
    list.AddText(ImGui::GetFont(), ImGui::GetFontSize(), corner,
                 ImGui::ColorConvertFloat4ToU32({0.82F, 0.85F, 0.89F, 1.0F}), help, nullptr,
                 size.x);
    list.PopClipRect();
    ui::enter_at({corner, size}, "help", "text", help);
    return corner.y;
}

} // namespace

std::optional<SceneMessage> message_for(const SceneSituation &now) {
    const bool waits = now.safety.state == servo::SafetyState::waiting;
    if (now.safety.state == servo::SafetyState::tripped) {
        return stopped(now);
    }
    if (!now.record.empty()) { // so that it is not taken for the present
        return record_shown(now);
    }
    if (now.is_paused) { // nothing else can happen until it goes on
        return SceneMessage{"paused", SceneUrgency::hint, "Paused: the device stands still.",
                            {},       "go on  P",         SceneAction::go_on};
    }
    if (waits && (now.is_in_exclusive_use || now.is_released || !now.is_zeroed)) {
        return waiting(now);
    }
    if (now.is_inside && !now.touching) {
        return with_lift({"inside", SceneUrgency::waits, "The tip is inside: pull out.",
                          "A surface is felt only from its outside."},
                         now, "pull it out");
    }
    if (waits) {
        return waiting(now);
    }
    return std::nullopt;
}

SceneSituation situation_of(const session::Session &session, const OpenedRecord &opened) {
    SceneSituation now;
    now.safety = session.latest().safety;
    now.is_lost = session.latest().health == device::DeviceHealth::lost;
    now.reconnects = session.device_choice().kind != factory::DeviceKind::simulated;
    now.is_in_exclusive_use = session.is_in_exclusive_use();
    now.is_released = session.is_kept_released();
    now.is_zeroed = session.is_zeroed();
    now.is_paused = session.servo().can_change_speed() && session.servo().speed() == 0.0;
    now.touching = session.latest().contact.touching;
    now.can_move_hand = session.hand().is_simulated() && !session.hand().follows_path();
    if (opened.is_shown()) {
        now.record = opened.playback().record().file.filename().string();
        const session::RunScene then = opened.playback().scene();
        if (then.sha256 != session.scenes().now().sha256) {
            now.scene_of_record = in_quotes(std::filesystem::path(then.file).filename().string());
        }
    }
    return now;
}

SceneAnswer draw_scene_overlay(session::Session &session, OpenedRecord &opened,
                               const SceneOverlay &shown, const Rectangle &view, float scale) {
    SceneAction action = SceneAction::none;
    float top = view.corner.y + margin(scale) + height_of_stop();
    float bottom = view.end().y;
    if (const std::optional<SceneMessage> message = message_for(shown.now)) {
        action = draw_message(*message, view, scale, top);
    }
    draw_stop_button(session, view, scale);
    if (shown.notice != nullptr) {
        draw_notice(*shown.notice, view, scale);
    }
    if (opened.is_shown()) {
        draw_record_controls(opened, view, scale);
    } else if (shown.has_help) {
        bottom = draw_help(session, view, scale);
    }
    return {action, {{view.corner.x, top}, {view.size.x, bottom - top}}};
}

/// That of the legend's button, the widest.
float width_of_view_buttons() {
    return ImGui::CalcTextSize("legend").x + 2.0F * ImGui::GetStyle().FramePadding.x;
}

float bottom_of_view_buttons(const Rectangle &view, float scale) {
    constexpr float kCount = 3.0F;
    return view.corner.y + 2.0F * margin(scale) + height_of_stop() +
           kCount * (ImGui::GetFrameHeight() + ImGui::GetStyle().ItemSpacing.y);
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
    ImGui::SetNextWindowPos({view.end().x - width_of_view_buttons() - margin(scale),
                             view.corner.y + 2.0F * margin(scale) + height_of_stop()});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.0F, 0.0F});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0.0F);
    ImGui::Begin("view", nullptr,
                 kOverlay | ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_AlwaysAutoResize);
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

Rectangle free_of_overlays(const Rectangle &view, const SideCards &cards, bool is_record,
                           float scale) {
    constexpr float kMin = 0.3F; // of the view's width and height
    const float left = cards.left + 2.0F * margin(scale);
    const float right = std::max(width_of_view_buttons(), cards.right) + 2.0F * margin(scale);
    const float top = margin(scale) + (1.0F + kMessageFont) * ImGui::GetTextLineHeight() +
                      ImGui::GetStyle().ItemSpacing.y + 2.0F * ImGui::GetStyle().WindowPadding.y;
    const float bottom =
        2.0F * margin(scale) +
        (is_record ? ImGui::GetFrameHeight() + 1.4F * ImGui::GetStyle().WindowPadding.y
                   : help_size(kHandHelp, view, scale).y);
    const Rectangle free{{view.corner.x + left, view.corner.y + top},
                         {view.size.x - left - right, view.size.y - top - bottom}};
    const bool has_room = free.size.x > kMin * view.size.x && free.size.y > kMin * view.size.y;
    if (!has_room && cards.right > 0.0F) {
        return free_of_overlays(view, {cards.left, 0.0F}, is_record, scale);
    }
    return has_room ? free : view;
}

} // namespace springdrive::app

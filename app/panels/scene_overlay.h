// What stands over the scene: one message at a time, the most important first, with the button that
// does it; what the scene lets one feel, and words on its parts; views, legend, menu, read-outs.
//
//   Session, OpenedRecord ──► SceneSituation ──► message_for ──► draw_scene_overlay
#pragma once

#include "app/panels/panels.h"
#include "app/panels/tuning_editor.h"
#include "app/panels/window_habits.h"
#include "app/plots/plot_panel.h"
#include "app/view/camera.h"
#include "app/view/view_state.h"
#include "app/widgets/rectangle.h"
#include "app/window/window.h"
#include "engine/servo/safety_status.h"
#include "engine/session/session.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace springdrive::app {

/// All that the message depends on.
struct SceneSituation {
    servo::SafetyStatus safety;
    bool is_lost = false;             ///< the device does not answer
    bool reconnects = false;          ///< a lost device is connected again by itself
    bool is_in_exclusive_use = false; ///< a step of the assistant moves the device
    bool is_released = false;         ///< the device is kept braking, by the assistant
    bool is_zeroed = true;            ///< its angles are known
    bool is_paused = false;           ///< a simulated device stands still
    bool touching = false;            ///< a surface
    bool is_inside = false;           ///< the tip lies in a solid without touching it
    bool can_move_hand = true;        ///< it is simulated, and follows no path
    std::string record;               ///< the file that is shown instead of the present; else empty
    std::string scene_of_record{};    ///< if it is not the one that is shown; else empty
};

/// What a message's button does.
enum class SceneAction : std::uint8_t { none, reset, go_on, show_present, zero, retract_hand };

/// The colour of the plate.
enum class SceneUrgency : std::uint8_t {
    stopped, ///< until somebody acts
    waits,   ///< something is to be done before the device can be felt
    hint,    ///< all is well
};

struct SceneMessage {
    const char *name; ///< in reports
    SceneUrgency urgency = SceneUrgency::hint;
    std::string text;
    std::string more{};      ///< a second sentence, less prominent; may be empty
    const char *button = ""; ///< its label; empty: there is nothing to press
    SceneAction action = SceneAction::none;
};

/// Nothing while the device is ready and the present is shown.
[[nodiscard]] std::optional<SceneMessage> message_for(const SceneSituation &now);

/// What the message over the scene depends on, except whether the tip is inside a solid.
[[nodiscard]] SceneSituation situation_of(const session::Session &session,
                                          const OpenedRecord &opened);

/// What is shown over the scene.
struct SceneOverlay {
    SceneSituation now;
    const Notice *notice = nullptr; ///< null: there is none
    bool has_help = true;           ///< how to use the mouse
};

struct SceneAnswer {
    SceneAction action = SceneAction::none; ///< what the message's button asks for
    Rectangle free;                         ///< of the view, between the message and the help
};

/// Over the scene: one message with its button, the button that stops, how to use the mouse.
[[nodiscard]] SceneAnswer draw_scene_overlay(session::Session &session, OpenedRecord &opened,
                                             const SceneOverlay &shown, const Rectangle &view,
                                             float scale);

/// Of the plate, with its distance to what is beside it; 0 while it is not shown.
[[nodiscard]] float width_of_scene_card(const session::Session &session,
                                        const SceneCardState &state, const Rectangle &view,
                                        float scale);

/// A plate with the scene's title and sentence, in the upper left corner of `place`; buttons to the
/// scenes before and after it in `files`, and one to put it away. Where the scene says where to
/// touch, also the angles from the normal to the push, as measured with both maps.
void draw_scene_card(session::Session &session, TuningEditor &editor,
                     std::span<const std::filesystem::path> files, SceneCardState &state,
                     const Rectangle &place, float scale);

/// The captions of the scene's parts; and where to touch, until it is touched.
void draw_captions(const session::Session &session, const Camera &camera, const Rectangle &view,
                   float scale, const ArrowSize &arrow = {});

/// Over everything: the keys and what they do. The mouse acts on what is below.
void draw_keys_overlay(const Rectangle &window);

enum class StartAnswer : std::uint8_t { none, got_it, keys, wrong_direction };

/// The first minute: what is simulated, how to move the hand, what to try.
/// @param height  that it needs at this width
[[nodiscard]] StartAnswer draw_start_card(const Rectangle &place, float &height);

/// Without panels: force, its direction and the depth, large, over a corner of the scene.
/// @param map  in use
void draw_read_outs(const PlotSubject &subject, control::MotionMap map, const Rectangle &view,
                    const Window::LargeText &text, float scale);

[[nodiscard]] float height_of_read_outs(const Rectangle &view);

/// What was chosen in the window's menu.
struct WindowMenuChoice {
    WindowOrder order = WindowOrder::none;
    std::filesystem::path opened; ///< a recent file; else empty
};

/// In a corner of the scene: what concerns the window itself, and recent files.
[[nodiscard]] WindowMenuChoice draw_window_menu(const WindowHabits &habits, const Rectangle &view,
                                                float scale);

/// At the right edge of the scene, below the button that stops.
/// @return the viewpoint whose button was pressed, if one was
[[nodiscard]] std::optional<Viewpoint> draw_view_buttons(const Rectangle &view, float scale);

/// Their width, and where the last one ends: the legend's button stands below.
[[nodiscard]] float width_of_view_buttons();
[[nodiscard]] float bottom_of_view_buttons(const Rectangle &view, float scale);

/// Widths of the plates at the edges of the scene, 0 where there is none.
struct SideCards {
    float left = 0.0F;
    float right = 0.0F; ///< beside the buttons of views
};

/// The part of the scene over which none of these is drawn, a message of two lines included: for
/// what must be seen whole. Where the scene is too small for it, the right plate, and then the
/// rest, is not left out.
[[nodiscard]] Rectangle free_of_overlays(const Rectangle &view, const SideCards &cards,
                                         bool is_record, float scale);

/// At the right edge of the scene: a button, or, once it is open, a plate with a row for each
/// thing.
/// @param top     of the button or plate
/// @param width   of the button
/// @param values  that are drawn now, whose ranges stand in the rows
/// @return the plate's width, 0 for a button
float draw_legend(ShownThings &shown, bool &is_open, const TouchValues &values,
                  const Rectangle &view, float top, float width, float scale);

} // namespace springdrive::app

// The panels: free functions that show a session and pass the user's requests to it.
#pragma once

#include "app/panels/doctor_popup.h"
#include "app/panels/event_log.h"
#include "app/panels/opened_record.h"
#include "app/panels/scene_card.h"
#include "app/panels/scene_message.h"
#include "app/panels/session_keeper.h"
#include "app/panels/stability_tab.h"
#include "app/panels/tuning_editor.h"
#include "app/panels/tuning_files.h"
#include "app/panels/window_habits.h"
#include "app/view/camera.h"
#include "app/view/view_state.h"
#include "app/widgets/rectangle.h"
#include "app/window/window.h"
#include "base/background.h"
#include "device/factory/device_factory.h"
#include "engine/session/session.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

/// State of the tuning panel between frames.
struct TuningPanelState {
    /// Tunings of presets, by file; read once.
    std::map<std::string, std::optional<control::Tuning>> presets;
    StabilityTabState stability;
    TuningFiles files;
    std::string file_name;    ///< being typed, to save or rename
    std::string file_message; ///< what came of it
    std::string compared;     ///< key of what the active tuning is compared with
};

/// The six parameters with derived quantities; other tabs show their stability, and compare
/// tunings.
void draw_tuning_panel(session::Session &session, TuningEditor &editor, TuningPanelState &state,
                       const Rectangle &place);

/// State of the servo panel between frames.
struct ServoPanelState {
    std::string record_error; ///< why the last record could not be started
    DoctorPopup doctor;
};

/// State, recording, speed of the simulation; tabs with timing, limits, what happened, and the
/// person's notes. True if the session is to be kept.
[[nodiscard]] bool draw_servo_panel(session::Session &session, const EventLog &log,
                                    SessionKeeper &keeper, ServoPanelState &state,
                                    const Rectangle &place);

enum class StimulusDirection : std::uint8_t { into_surface, x, y, z };

/// By linear regression of force on depth; NaN if the depth hardly changed.
struct StiffnessMeasured {
    double slope_N_per_m = std::numeric_limits<double>::quiet_NaN();
    double deviation_N_per_m = std::numeric_limits<double>::quiet_NaN(); ///< standard deviation
};
[[nodiscard]] StiffnessMeasured measured_stiffness(const record::ChannelStore &store, double from_s,
                                                   double to_s);

/// 5 mm within two seconds.
[[nodiscard]] inline simulated::HandStimulus pressing() {
    simulated::HandStimulus stimulus;
    stimulus.kind = simulated::StimulusKind::hold;
    stimulus.amplitude_m = 0.005;
    stimulus.duration_s = 2.0;
    return stimulus;
}

/// State of the hand's tab between frames.
struct HandTabState {
    simulated::HandStimulus stimulus = pressing();
    StimulusDirection direction = StimulusDirection::into_surface;
    std::optional<simulated::HandStimulus> played; ///< the last one
    double started_s = 0.0;
    double predicted_N_per_m = 0.0; ///< when it began
    std::optional<StiffnessMeasured> measured;
    std::string path;  ///< file being typed
    std::string error; ///< why a path cannot be followed
};

/// The simulated hand follows the path of a CSV file, `t,x,y,z`; what is wrong with it is shown in
/// the tab.
void follow_path_file(session::Session &session, HandTabState &state,
                      const std::filesystem::path &file);

/// Within the scene panel: how firm the simulated hand is, the paths that it follows, and test
/// signals with the stiffness that they meet.
void draw_hand_tab(session::Session &session, HandTabState &state);

/// A device that the session could have instead.
struct DeviceOffer {
    session::DeviceChoice choice;
    std::string problem; ///< why it cannot be used, with what to do; empty if it can
};

/// State of the plant's tab between frames.
struct PlantTabState {
    std::vector<DeviceOffer> offers; ///< when the list was opened last
    /// A board that hangs may take seconds to answer.
    Background<std::vector<factory::PresentDevice>> survey;
    bool dragging_delay = false;
    double delay_periods = 0.0;
    std::string error; ///< why the last change was refused
    DoctorPopup doctor;
    std::function<void()> draw_assistant_offer; ///< below the device; empty: there is none
};

/// Within the scene panel: which device, and its connection; the servo's rate; delay and effects of
/// a simulated device.
void draw_plant_tab(session::Session &session, PlantTabState &state);

/// The device's name, and whether it is simulated.
[[nodiscard]] std::string device_text(const session::Session &session);

/// State of the record's tab between frames.
struct RecordTabState {
    std::vector<std::filesystem::path> files; ///< offered in the list
    std::string path;                         ///< being typed
};

/// Within the scene panel: opens a record, compares it with the active tuning.
void draw_record_tab(session::Session &session, TuningEditor &editor, OpenedRecord &opened,
                     RecordTabState &state);

/// Over the lower edge of the scene: where the record stands, and how fast it is played.
void draw_record_controls(OpenedRecord &opened, const Rectangle &view, float scale);

/// State of the scene panel between frames.
struct ScenePanelState {
    std::vector<std::filesystem::path> files; ///< offered in the list
    std::string typed;                        ///< path being typed
    SceneCardState card;
    HandTabState hand;
    PlantTabState plant;
    RecordTabState record;
};
void draw_scene_panel(session::Session &session, TuningEditor &editor, OpenedRecord &opened,
                      ScenePanelState &state, const Rectangle &place);

/// Over everything: the keys and what they do. The mouse acts on what is below.
void draw_keys_overlay(const Rectangle &window);

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

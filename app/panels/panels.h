// The panels: free functions that show a session and pass the user's requests to it.
#pragma once

#include "app/doctor/checks.h"
#include "app/panels/session_keeper.h"
#include "app/panels/stability_tab.h"
#include "app/panels/tuning_editor.h"
#include "app/plots/plot_panel.h"
#include "app/widgets/rectangle.h"
#include "app/widgets/widgets.h"
#include "base/background.h"
#include "device/factory/device_factory.h"
#include "engine/session/record_playback.h"
#include "engine/session/run_folder.h"
#include "engine/session/session.h"

#include <array>
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

/// A button that is grey, and does nothing, unless `is_enabled`.
[[nodiscard]] inline bool enabled_button(const char *label, bool is_enabled) {
    const ui::Disabled disabled(!is_enabled);
    return ui::button(label);
}

/// State of the tuning panel between frames.
struct TuningPanelState {
    /// Tunings of presets, by file; read once.
    std::map<std::string, std::optional<control::Tuning>> presets;
    StabilityTab stability;
    TuningFiles files;
    std::string file_name;    ///< being typed, to save or rename
    std::string file_message; ///< what came of it
    std::string compared;     ///< key of what the active tuning is compared with
};

/// The six parameters with derived quantities; other tabs show their stability, and compare
/// tunings.
void draw_tuning_panel(session::Session &session, TuningEditor &editor, TuningPanelState &state,
                       const Rectangle &place);

// What follows from the active tuning: stiffness, damping, lag, added mass; and the active dR,
// where the winding guard or the observer of R holds it above what was requested.

/// The largest of the motors' active dR: at least the requested one.
[[nodiscard]] double active_dR_Ohm(const session::Session &session);

/// A checkbox to observe the windings' resistances, and what is known of them.
void draw_observed_resistances(session::Session &session);

/// Why dR is larger than requested, if it is.
void show_held_up_dR(const session::Session &session);

/// Static stiffness at the tip along a unit vector, of the coupling alone, with the dR that acts,
/// at the present configuration, on a rigid surface: (27) with the transpose map, nᵀ J⁻ᵀ K_q J⁻¹ n
/// (21) with the inverse map.
[[nodiscard]] double tip_stiffness_N_per_m(const session::Session &session, const Vector3 &along);

void show_consequences(const session::Session &session);

/// As --device names it.
[[nodiscard]] std::string name_of(const session::DeviceChoice &choice);

/// The doctor in the window: offered where something is refused, shown over the panels. Asks in the
/// background, so that frames go on.
class DoctorPopup {
public:
    /// A small button beside an error, which asks.
    /// @param device  what is to be used, as --device names it
    void offer(const std::string &device, double servo_hz);

    /// Opens the popup, and fills it when the answer comes.
    void ask(const std::string &device, double servo_hz);

    /// The popup, if it is open: once a frame.
    void draw();

private:
    Background<std::vector<doctor::Check>> asking_;
    std::optional<std::vector<doctor::Check>> checks_;
    std::string error_;
    bool opens_ = false;
};

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

/// What scene and plots show while a record is open.
enum class RecordView : std::uint8_t {
    present,    ///< the record is not shown
    behind,     ///< the present, with the record faintly behind it in the plots
    instead_of, ///< the record
};

inline constexpr std::array<const char *, 3> kRecordViewLabels{
    "show the present", "present, record behind", "show the record"};

/// A record in the window: shown instead of the present, or behind it, and computed again with the
/// active tuning.
class OpenedRecord {
public:
    /// Opens a record, or the first record of a run folder; in the background.
    void open(const std::filesystem::path &path);
    void open_part(std::size_t part);
    /// The same record, which does not fit into memory, from that time on.
    void open_from(double from_s);
    void close();

    /// Once a frame. @param tuning  the active one
    void update(double frame_s, const control::Tuning &tuning);

    [[nodiscard]] session::RecordPlayback &playback() { return playback_; }
    [[nodiscard]] const session::RecordPlayback &playback() const { return playback_; }
    /// The folder that the record belongs to; empty if it is a file alone.
    struct Run {
        std::filesystem::path folder;
        session::RunFacts facts;
        std::size_t part = 0; ///< the number of the record
    };
    [[nodiscard]] const std::optional<Run> &run() const { return run_; }
    /// Why nothing was opened, or computed; else empty.
    [[nodiscard]] const std::string &error() const {
        return error_.empty() ? playback_.error() : error_;
    }

    [[nodiscard]] bool is_shown() const {
        return view == RecordView::instead_of && playback_.is_open();
    }
    [[nodiscard]] PlotSubject subject(const session::Session &session) const;

    RecordView view = RecordView::instead_of;
    bool asks = false; ///< what the active tuning would have done

private:
    void load(const std::filesystem::path &file, std::optional<Run> run,
              double from_s = -std::numeric_limits<double>::infinity());
    void renew_behind();

    session::RecordPlayback playback_;
    std::optional<Run> run_;
    std::optional<Run> run_of_next_; ///< of the record that is being loaded
    bool loads_ = false;
    std::uint32_t number_ = 0; ///< of records opened so far
    std::string error_;
    std::optional<PlotTrace> behind_; ///< the record itself, or the answer
    const void *behind_of_ = nullptr; ///< the store that it is a copy of
};

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

/// State of the plate over the scene between frames.
struct SceneCardState {
    std::uint32_t scene = 0;  ///< number of the scene that all of this is about
    bool is_put_away = false; ///< for this scene
    /// The angle from normal to push by map, as last measured.
    std::array<std::optional<double>, 2> angle_rad;
};

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

} // namespace springdrive::app

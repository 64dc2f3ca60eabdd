// The two windows of a session: the experimenter's, with panels and the whole device, and the
// participant's. The stimuli are hidden from the experimenter at first, so that nothing in the
// experimenter's face or voice can tell of them.
#pragma once

#include "app/stage/frame_loop.h"
#include "app/stage/view_control.h"
#include "app/study/participant/participant_window.h"
#include "app/study/session/study_session_state.h"
#include "app/view/renderer.h"
#include "app/view/view_state.h"
#include "app/widgets/rectangle.h"
#include "app/window/window.h"
#include "engine/session/session.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/results/study_results.h"
#include "engine/study/store/study_contents.h"
#include "engine/study/store/study_store.h"

#include <cstddef>
#include <cstdint>
#include <future>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {

/// What has been fitted so far to the present participant's trials in one condition.
class LiveFit {
public:
    explicit LiveFit(const study::Protocol &protocol) : protocol_(protocol) {}

    /// Begins a fit of that participant's condition, unless one runs: then afterwards.
    void request(const study::StudyContents &contents, const std::string &participant,
                 std::size_t condition, study::DeviceKind device);

    /// The newest that is ready; null before the first. Call once a frame.
    [[nodiscard]] const study::SeriesResult *latest();

private:
    void begin(study::Series series);

    study::Protocol protocol_;
    std::optional<study::Series> next_;
    std::future<study::SeriesResult> running_;
    std::optional<study::SeriesResult> latest_;
};

/// In the present panel, side by side, as high as it leaves room.
void draw_live_charts(const study::Protocol &protocol, const study::SeriesResult &result);

enum class EndAsked : std::uint8_t { nothing, stop, leave };

struct ExperimenterPanelState {
    bool is_paused = false;
    bool shows_stimuli = false; ///< condition, level, answers and fit
    std::string error;          ///< why the device could not be zeroed
    std::string note;           ///< being typed
    double typed_s = 0.0;       ///< when its last key was, by ImGui::GetTime
    std::vector<std::string> notes_of_today;
    EndAsked asked = EndAsked::nothing; ///< until it is confirmed
};

struct ExperimenterActs {
    ExperimenterOrders orders;
    bool emergency_stop = false;
    bool zeroes_device = false;      ///< it is held in its zero pose
    std::optional<std::string> note; ///< to be stored
};

struct StudyWindowOptions {
    ParticipantWindow::Wish participant;
    Window::Size size;  ///< of the experimenter's; 0 × 0 for its own
    double scale = 0.0; ///< of text and panels; 0 for the display's
};

class StudyWindow {
public:
    /// @param session  and the store: must outlive it
    /// @throw InputError if no window can be opened
    StudyWindow(const StudyWindowOptions &options, session::Session &session,
                study::StudyStore &store, const study::Protocol &protocol);

    /// Shows this for a frame.
    /// @throw InputError if there are no letters for it
    StudySessionFrame show(const ParticipantPicture &picture, const StudySessionState &state);
    /// See ShowsScene.
    void show_scene(const scene::Scene &scene, const scene::TouchSpot &spot);

    [[nodiscard]] ReportedWindow reported() const {
        return {window_.size(), window_.scale(), window_.has_waiting_input()};
    }

    /// What a session should keep of its screens.
    [[nodiscard]] std::vector<study::Setting> facts() const;

private:
    void draw_experimenter(const StudySessionState &state, ExperimenterActs &acts);
    void report_participant(const StudySessionState &state, const ParticipantPicture &picture);
    void draw_view(const Rectangle &place);
    void renew_fit(const StudySessionState &state);
    void give_keys_back();
    void store_note(const StudySessionState &state, const std::string &text);

    session::Session &session_;
    study::StudyStore &store_;
    study::Protocol protocol_;
    Window window_;
    Renderer renderer_;
    ViewControl view_control_;
    ParticipantWindow participant_window_;
    ExperimenterPanelState panel_;
    LiveFit fit_;
    double frame_end_s_ = 0.0;     ///< of the last one, by the steady clock
    double longest_frame_s_ = 0.0; ///< since the last report
    std::size_t fitted_trials_ = 0;
    std::uint32_t shown_scene_ = 0;
    std::optional<Vector3> spot_m_; ///< that is touched
};

/// What the experimenter's view shows of the device and the hand.
/// @param surface    that is touched
/// @param hidden_at  while stimuli are hidden: where the tip is shown in contact, whichever way it
///                   yields; no force is shown then, in contact or not
[[nodiscard]] ViewState experimenter_view(const servo::ServoSample &now,
                                          const device::DeviceDescription &device,
                                          const contact::HapticSurface &surface,
                                          const std::optional<Vector3> &hidden_at);

} // namespace springdrive::app::study_screen

// "Can you feel it?", one visitor after the other, unattended:
//
//   start ──► study session ──► own curve ──► start
//     │         └ walked away ─────────────────► start
//     └► a visitor who is made up: three trials, the others reckoned, the curve ──► start
//
// A visit's trials are in a study in memory, which is gone when the next visitor begins: nothing of
// a visitor is in any file. A visitor's study session is a participant's in which nobody looks
// after the visitor: what an experimenter would do is done between it and the window.
//
//   study session ──picture──► buttons, "Still there?" ──► window
//   study session ◄──inputs── answers of a visitor who is made up ◄── window
#pragma once

#include "app/stage/frame_loop.h"
#include "app/study/participant/participant_picture.h"
#include "app/study/participant/participant_window.h"
#include "app/study/session/resumable.h"
#include "app/study/session/study_session_state.h"
#include "app/study/session/trial_presenter.h"
#include "engine/session/session.h"
#include "engine/study/methods/psychometric_function.h"
#include "engine/study/observers/simulated_study_session.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/results/study_results.h"
#include "engine/study/store/study_contents.h"
#include "engine/study/store/study_store.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace springdrive::app::visitors {

inline constexpr double kAskedAfter_s = 30.0; ///< without a sign of anybody: "Still there?"
inline constexpr double kGoneAfter_s = 40.0;
/// A visitor who is made up is shown for so many trials.
inline constexpr std::size_t kShownTrials = 3;

/// Why a visit was ended before its study session was through.
enum class VisitEnd : std::uint8_t {
    none,
    gone,       ///< nobody was there any more
    left,       ///< by Escape
    seen_enough ///< of a visitor who is made up
};

struct VisitsPlan {
    study::Protocol protocol; ///< a task for visitors: see `validate_for_visitors`
    study::StudySetting setting;
    study::ProtocolFolders folders;
    study::PsychometricFunction made_up; ///< who answers where nobody feels anything
    bool has_device = false;             ///< that somebody holds: else nobody feels anything
    bool is_show = false;                ///< made-up visitors only, without anybody at the screen
};

/// Whose answers they are.
enum class Visitor : std::uint8_t {
    feels,   ///< a person at a device
    guesses, ///< a person, where there is nothing to feel
    made_up
};

class Visits {
public:
    static constexpr double kResult_s = 60.0;     ///< for which a curve stays without a press
    static constexpr double kShowResult_s = 15.0; ///< of a show

    /// @param session  started, with the protocol's device. All must outlive this
    Visits(VisitsPlan plan, session::Session &session, study_screen::ShowsScene show_scene);

    // As of a StudySession.
    void start() { frames_.start(whole()); }
    [[nodiscard]] const study_screen::ParticipantPicture &picture() const {
        return frames_.picture();
    }
    [[nodiscard]] const study_screen::StudySessionState &state() const { return state_; }
    /// Until a frame says that everything is to end.
    [[nodiscard]] bool is_over() const { return frames_.is_over(); }
    /// @throw InputError if the device has failed for good
    void resume(study_screen::StudySessionFrame frame);

    /// Visits that were begun.
    [[nodiscard]] int begun() const { return begun_; }

private:
    [[nodiscard]] study_screen::Resumable<> whole();
    [[nodiscard]] study_screen::Resumable<> visits();
    [[nodiscard]] study_screen::Resumable<Visitor> wait_for_visitor();
    [[nodiscard]] study_screen::Resumable<VisitEnd> sit(study::StudyStore &store, Visitor visitor);
    [[nodiscard]] study_screen::Resumable<bool> reckon_rest(study::StudyStore &store);
    [[nodiscard]] study_screen::Resumable<> show_curve(const study::StudyContents &visit,
                                                       Visitor visitor);
    /// A picture of ours.
    [[nodiscard]] study_screen::Frames::Next show(study_screen::ParticipantPicture picture,
                                                  study_screen::StudySessionStep step);
    [[nodiscard]] study::SimulatedParticipant made_up_visitor() const;

    VisitsPlan plan_;
    session::Session &session_;
    study_screen::ShowsScene show_scene_;
    study_screen::StudySessionState state_; ///< of what is shown
    int begun_ = 0;
    study_screen::Frames frames_;
};

/// Why a protocol is no task for visitors, in a line with what to do; empty when it is one: one
/// condition, a forced choice about an angle on a logarithmic scale, no questions.
[[nodiscard]] std::string validate_for_visitors(const study::Protocol &protocol);

// @pre of the following: the protocol is a task for visitors

/// The fit of the only participant's trials; nothing before the first one that counts.
[[nodiscard]] std::optional<study::SeriesResult> result_of_visit(const study::Protocol &protocol,
                                                                 const study::StudyContents &visit);

/// Axes, and what `result` has of dots and fit.
[[nodiscard]] study_screen::OwnCurve curve_of(const study::Protocol &protocol,
                                              const std::optional<study::SeriesResult> &result);

/// "14 degrees (9 to 22)"; where the interval reaches an end of what was presented, "less than 4
/// degrees" or "more than 38 degrees".
[[nodiscard]] std::string threshold_words(const study_screen::OwnCurve &curve);

/// The one window of the visitors' task: the participant's, on whatever screen visitors have.
/// Ctrl+Alt+Q, a signal and the end of the display ask to end; Ctrl+Alt+Z says that the device is
/// held in its zero pose.
class VisitorWindow {
public:
    /// @param session  must outlive it. @throw InputError if no window can be opened
    VisitorWindow(const study_screen::ParticipantWindow::Wish &wish, session::Session &session)
        : session_(session), window_(wish) {}

    /// Shows this for a frame.
    study_screen::StudySessionFrame show(const study_screen::ParticipantPicture &picture,
                                         const study_screen::StudySessionState &state);
    [[nodiscard]] ReportedWindow reported() const { return {window_.framebuffer()}; }
    /// See ShowsScene.
    void show_scene(const scene::Scene &scene, const scene::TouchSpot &spot);

private:
    void obey_staff(const std::vector<study_screen::ParticipantInput> &inputs);
    void report(const study_screen::ParticipantPicture &picture,
                const study_screen::StudySessionState &state) const;

    session::Session &session_;
    study_screen::ParticipantWindow window_;
    std::set<std::string> held_keys_; ///< ctrl and alt
    bool is_asked_to_end_ = false;
};

} // namespace springdrive::app::visitors

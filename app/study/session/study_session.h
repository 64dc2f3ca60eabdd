// A person's session of a study, from the first word on the screen to the last: instructions,
// practice, trials, breaks, and whatever happens in between; resumed once a frame. Who draws and
// who types is for the caller.
//
// What comes next, what is stored and when the session ends is for engine/study/conduct; the
// servo's part of a trial for trial_presenter.h.
#pragma once

#include "app/study/session/resumable.h"
#include "app/study/session/study_session_state.h"
#include "app/study/session/trial_presenter.h"
#include "app/study/sound/masking_noise.h"
#include "engine/session/session.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/protocol_check.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/store/study_store.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {

/// Stops of the device in a session: each is stored with the trial in which it was, or noted; and
/// when the device is reset after one that nobody requested.
class DeviceStops {
public:
    /// @param resets_itself  after a calm, unless a requested stop is held
    /// @param note           stores what it is told of a stop outside of trials
    DeviceStops(session::Session &session, bool resets_itself,
                std::function<void(const std::string &)> note);

    /// Every frame, and before what is known of the device is relied on: with all that the servo
    /// has published.
    void watch();

    /// A stop from now on is the trial's.
    void begin_trial();
    /// Nothing outside of a trial. @param is_stored  with the trial; otherwise it is noted now
    void end_trial(bool is_stored);

    /// A person lets the device go on.
    void let_go_on();
    /// The calm after a stop begins anew.
    void begin_calm();
    /// Every frame of a stop: resets the device when it was calm for a while.
    void reset_when_calm();

    /// Of the session so far.
    [[nodiscard]] int count() const { return count_; }

private:
    void note_reset();

    session::Session &session_;
    bool resets_itself_;
    std::function<void(const std::string &)> note_;
    int count_ = 0;
    bool was_tripped_ = false;
    std::uint32_t held_stop_ = 0; ///< as last seen
    bool is_in_trial_ = false;
    std::optional<std::string> of_trial_; ///< the stop in the present one
    bool is_reset_ = false;               ///< and not yet seen to run
    double calm_from_s_ = 0.0;
    double reset_s_ = 0.0; ///< the last time
};

struct StudySessionPlan {
    study::Protocol protocol;
    study::StudySetting setting;
    study::ProtocolFolders folders;
    std::string participant;             ///< in the store
    bool keeps_records = true;           ///< a servo record of each trial
    bool plays_noise = true;             ///< the protocol's masking noise
    std::vector<study::Setting> facts{}; ///< of the session, besides those of the device
    bool offers_practice_again = true;   ///< after the practice, where two keys answer
    bool is_attended = true; ///< else a device that can reach a hand starts again by a person alone
};

class StudySession {
public:
    /// @param session  started; with the protocol's device and the scene of a condition
    /// @throw InputError for ways to answer that this program cannot take, and for a participant
    ///        whose former sessions were on another kind of device
    StudySession(study::StudyStore &store, StudySessionPlan plan, session::Session &session,
                 ShowsScene show_scene);
    /// A session that has not come to its end, by an error, is stored as failed.
    ~StudySession() { fail(); }
    StudySession(const StudySession &) = delete;
    StudySession &operator=(const StudySession &) = delete;

    /// Begins the session. @throw InputError if the masking noise cannot be played: there is then
    /// no session; and as `resume` does
    void start();

    /// What is to be shown for a frame, in which the session is to be advanced.
    [[nodiscard]] const ParticipantPicture &picture() const { return frames_.picture(); }
    [[nodiscard]] const StudySessionState &state() const { return state_; }

    /// Goes on after that frame. @throw InputError from the store, for a scene, or for windings
    ///        that cannot be warmed: it can then not go on
    void resume(StudySessionFrame frame);

    /// Stored as failed, if it has begun and not come to its end: nothing comes after it.
    void fail();

    [[nodiscard]] bool is_over() const { return frames_.is_over(); }
    /// As stored. @pre it is over
    [[nodiscard]] study::SessionEnding ending() const { return stored_ending_.value(); }

private:
    void require_device_of_before() const;
    void recall_practice();
    [[nodiscard]] Frames::Next show(ParticipantPicture picture);
    [[nodiscard]] Resumable<> show_until_key(StudySessionStep step,
                                             const ParticipantPicture &picture);
    [[nodiscard]] bool is_answer_key(const std::vector<ParticipantInput> &inputs) const;

    [[nodiscard]] Resumable<> whole();
    [[nodiscard]] Resumable<study::SessionEnding> trials();
    [[nodiscard]] Resumable<> before_next();
    [[nodiscard]] Resumable<> present(const study::PlannedTrial &planned);
    [[nodiscard]] Resumable<> introduce(const study::PlannedTrial &planned);
    [[nodiscard]] Resumable<> end_practice();
    [[nodiscard]] Resumable<> practise_again();
    void note_practice();
    void keep_noise();
    void end_noise();
    [[nodiscard]] Resumable<> rest(double seconds);
    [[nodiscard]] Resumable<> take_break(double seconds, StudySessionStep step);
    [[nodiscard]] Resumable<> wait_while_paused();
    [[nodiscard]] Resumable<bool> warm_up();
    [[nodiscard]] Resumable<> begin();
    [[nodiscard]] Resumable<study::SessionEnding> ask_after_last();
    [[nodiscard]] Resumable<> say_goodbye();
    [[nodiscard]] Resumable<> let_go();
    [[nodiscard]] std::vector<study::QuestionnaireItem>
    open_questions(study::QuestionnaireTime when) const;
    [[nodiscard]] Resumable<> ask_questions(study::QuestionnaireTime when);
    [[nodiscard]] Resumable<std::optional<std::string>>
    answer_to(const study::QuestionnaireItem &item);
    [[nodiscard]] Resumable<> make_ready(const study::PlannedTrial &planned);
    void note(const std::string &kind, const std::string &text);
    void note_gaps_of_record();
    [[nodiscard]] Resumable<std::optional<study::Trial>> present_watched();
    [[nodiscard]] Resumable<> tell_of(const study::Trial &trial, bool is_stored);
    void note_trials();
    [[nodiscard]] std::optional<study::SessionEnding> ending_after_frame() const;
    [[nodiscard]] study::Session begun() const;

    study::StudyStore &store_;
    StudySessionPlan plan_;
    session::Session &session_;
    study::Session begun_; ///< in the store
    StudySessionState state_;
    TrialPresenter presenter_;
    std::optional<study::SessionEnding> ending_; ///< what is shown is over with it
    std::optional<study::SessionEnding> stored_ending_;
    ExperimenterOrders orders_; ///< those that wait to be obeyed
    bool has_begun_ = false;
    bool was_practising_ = false;
    std::vector<study::PlannedTrial> practised_; ///< in the present practice
    bool has_presented_ = false;
    int last_block_ = 0;
    int since_break_ = 0;
    std::optional<MaskingNoise> noise_;
    int noise_gaps_ = 0; ///< of outputs that were in use before
    DeviceStops stops_;
    bool has_trials_left_ = true;
    std::optional<study::Trial> presented_; ///< the last one, if it was presented to its end
    std::optional<int> presented_again_;    ///< trials, while the participant practises again
    Frames frames_;                         ///< last: what it holds uses all the others
};

// What a check of a protocol adds where a person is to take part: a simulated observer has neither
// keys nor a screen.

/// Errors: names in `responses.keys` that nobody can press, gestures along the way off a spot, and
/// an adjustment of what cannot be changed while it is felt. Warnings: texts that are too long to
/// be read on a screen of 1280 × 720.
/// @throw InputError if there is no font
[[nodiscard]] study::ProtocolFindings check_for_persons(const study::Protocol &protocol,
                                                        const study::StudySetting &setting);

/// The first of its errors as "WHERE: WHAT; REMEDY"; empty if there is none.
[[nodiscard]] std::string validate_for_participants(const study::Protocol &protocol,
                                                    const study::StudySetting &setting);

} // namespace springdrive::app::study_screen

// A person's session of a study, from the first word on the screen to the last: instructions,
// practice, trials, breaks, and whatever happens in between. Who draws and who types is the port's.
//
// What comes next, what is stored and when the session ends is for engine/study/conduct; the
// servo's part of a trial for trial_presenter.h.
#pragma once

#include "app/study/sitting/device_stops.h"
#include "app/study/sitting/sitting_port.h"
#include "app/study/sitting/sitting_state.h"
#include "app/study/sitting/trial_presenter.h"
#include "app/study/sound/masking_noise.h"
#include "engine/session/session.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/store/study_store.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {

struct SittingPlan {
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

class Sitting {
public:
    /// @param session  started; with the protocol's device and the scene of a condition
    /// @throw InputError for ways to answer that this program cannot take, and for a participant
    ///        whose former sessions were on another kind of device
    Sitting(study::StudyStore &store, SittingPlan plan, session::Session &session,
            SittingPort &port);

    /// @throw InputError if the masking noise cannot be played: there is then no session; from the
    ///        store, or for windings that cannot be warmed: it is then ended as failed, if possible
    study::SessionEnding run();

private:
    struct Ends { ///< thrown out of whatever is shown
        study::SessionEnding how;
    };

    void require_device_of_before() const;
    void recall_practice();
    SittingFrame show(ParticipantPicture picture);
    void show_for(double seconds, const ParticipantPicture &picture);
    void show_until_key(SittingStep step, const ParticipantPicture &picture);
    [[nodiscard]] bool is_answer_key(const std::vector<ParticipantInput> &inputs) const;

    [[nodiscard]] std::optional<study::Trial> present(const study::PlannedTrial &planned);
    void introduce(const study::PlannedTrial &planned);
    void end_practice();
    void practise_again();
    void keep_noise();
    void end_noise();
    void rest(double seconds);
    void take_break(double seconds);
    void begin_block();
    void wait_while_paused();
    [[nodiscard]] bool warm_up();
    void begin();
    [[nodiscard]] std::optional<study::SessionEnding> ask_after_last();
    void say_goodbye();
    void let_go();
    [[nodiscard]] std::vector<study::QuestionnaireItem>
    open_questions(study::QuestionnaireTime when) const;
    void ask_questions(study::QuestionnaireTime when);
    [[nodiscard]] std::optional<std::string> answer_to(const study::QuestionnaireItem &item);
    void make_ready(const study::PlannedTrial &planned);
    void note(const std::string &kind, const std::string &text);
    void note_gaps_of_record();
    [[nodiscard]] std::optional<study::Trial> present_watched();
    void tell_of(const study::Trial &trial, bool is_stored);
    void note_trials();
    [[nodiscard]] std::optional<study::SessionEnding> ending_before_next();
    [[nodiscard]] study::Session begun() const;

    study::StudyStore &store_;
    SittingPlan plan_;
    session::Session &session_;
    SittingPort &port_;
    SittingState state_;
    TrialPresenter presenter_;
    std::optional<study::SessionEnding> ending_;
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
};

} // namespace springdrive::app::study_screen

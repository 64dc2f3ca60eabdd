// Where each participant of a study stands.
#pragma once

#include "engine/study/conduct/sequence.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {

struct Progress {
    std::string participant;
    int number = 1;
    int sessions = 0;
    std::optional<SessionEnding> last_ending; ///< nothing without a session, and while one runs
    std::vector<DeviceKind> devices;          ///< of the sessions, each once
    int trials = 0;                           ///< all of them
    int practice = 0;
    int marked = 0;
    int blocks_unfinished = 0;        ///< ended because too many of their trials were marked
    std::optional<PlannedTrial> next; ///< nothing after the last trial
    std::size_t next_block = 0;       ///< of that, index into `Protocol::blocks`
    bool has_open_questions = false;  ///< the session was ended in those after the last trial
};

/// Of all participants, in the order in which they were added.
/// @pre validate(protocol) is empty
/// @throw InputError as `sequence_after` does
[[nodiscard]] std::vector<Progress> progress_of(const Protocol &protocol,
                                                const StudyContents &contents);

/// The questions that the participant has not answered, those who would rather not say included.
[[nodiscard]] std::vector<QuestionnaireItem> open_questions(const Protocol &protocol,
                                                            const StudyContents &contents,
                                                            std::string_view participant,
                                                            QuestionnaireTime when);

} // namespace springdrive::study

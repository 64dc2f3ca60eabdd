#include "engine/study/store/study_contents.h"

#include "base/input_error.h"
#include "base/one_line.h"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>

namespace springdrive::study {

std::string text_of(const TrialPlace &place) {
    return fmt::format("block {}, position {}, attempt {}", place.block, place.position,
                       place.attempt);
}

int next_participant_number(const StudyContents &contents) {
    int highest = 0;
    for (const Participant &participant : contents.participants) {
        highest = std::max(highest, participant.number);
    }
    return highest + 1;
}

std::string no_participant_text(std::string_view code) {
    return "has no participant " + in_quotes(code) + "; springdrive study status lists them";
}

const Participant &participant_of(const StudyContents &contents, std::string_view code) {
    const auto found = std::ranges::find(contents.participants, code, &Participant::code);
    if (found == contents.participants.end()) {
        throw InputError("the study " + no_participant_text(code));
    }
    return *found;
}

const Session &session_of(const StudyContents &contents, SessionId id) {
    const auto found = std::ranges::find(contents.sessions, id, &Session::id);
    if (found == contents.sessions.end()) {
        throw InputError(fmt::format("the study has no session {}", id));
    }
    return *found;
}

std::vector<Trial> trials_of(const StudyContents &contents, std::string_view participant) {
    std::vector<Trial> trials;
    std::ranges::copy_if(
        contents.trials, std::back_inserter(trials),
        [participant](const Trial &trial) { return trial.participant == participant; });
    return trials;
}

std::vector<Trial> trials_on(const StudyContents &contents, DeviceKind device) {
    std::vector<Trial> trials;
    std::ranges::copy_if(contents.trials, std::back_inserter(trials), [&](const Trial &trial) {
        return session_of(contents, trial.session).device == device;
    });
    return trials;
}

bool counts(const Trial &trial) {
    return !trial.is_practice && !trial.is_catch && trial.marks.empty();
}

} // namespace springdrive::study

#include "engine/study/store/study_contents.h"

#include "base/input_error.h"
#include "base/one_line.h"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>

namespace springdrive::study {

namespace {

bool is_capital(char c) { return c >= 'A' && c <= 'Z'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

} // namespace

std::string text_of(const TrialPlace &place) {
    return fmt::format("block {}, position {}, attempt {}", place.block, place.position,
                       place.attempt);
}

std::string what_is_wrong_with_code(std::string_view code) {
    const auto digits = std::ranges::find_if_not(code, is_capital);
    const auto letters_count = digits - code.begin();
    const auto digits_count = code.end() - digits;
    const bool is_code = letters_count >= 1 && letters_count <= 3 && digits_count >= 1 &&
                         digits_count <= 4 && std::all_of(digits, code.end(), is_digit);
    return is_code
               ? std::string()
               : in_quotes(code) + " is no participant's code: one to three capital letters and "
                                   "one to four digits, as P01; names are not stored";
}

int next_participant_number(const StudyContents &contents) {
    int highest = 0;
    for (const Participant &participant : contents.participants) {
        highest = std::max(highest, participant.number);
    }
    return highest + 1;
}

const Participant &participant_of(const StudyContents &contents, std::string_view code) {
    const auto found = std::ranges::find(contents.participants, code, &Participant::code);
    if (found == contents.participants.end()) {
        throw InputError("the study has no participant " + in_quotes(code));
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

#include "engine/study/store/study_contents.h"

#include "base/assertions.h"
#include "base/input_error.h"
#include "base/input_file.h"
#include "base/text.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>

namespace springdrive::study {

namespace {

constexpr std::string_view kForm = "dddd-dd-ddTdd:dd:dd.dddZ"; ///< d: a digit

bool has_the_form(std::string_view text) {
    const auto fits = [](char c, char form) {
        return form == 'd' ? c >= '0' && c <= '9' : c == form;
    };
    return text.size() == kForm.size() && std::ranges::equal(text, kForm, fits);
}

template <typename Number> Number digits(std::string_view text, std::size_t at, std::size_t count) {
    Number number{};
    std::from_chars(text.data() + at, text.data() + at + count, number);
    return number;
}

constexpr std::string_view kReplacement = "[removed]";

bool is_capital(char c) { return c >= 'A' && c <= 'Z'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

bool is_same_letter(char typed, char of_code) {
    return typed == of_code || (is_capital(of_code) && typed == of_code - 'A' + 'a');
}

/// Where the code stands next, from `begin` on; npos if it does not.
std::size_t find_code(std::string_view text, std::string_view code, std::size_t begin) {
    for (std::size_t at = begin; at + code.size() <= text.size(); ++at) {
        if (!std::ranges::equal(text.substr(at, code.size()), code, is_same_letter)) {
            continue;
        }
        std::size_t first = at;
        while (first > 0 && is_capital(text[first - 1])) {
            --first;
        }
        std::size_t end = at + code.size();
        while (end < text.size() && is_digit(text[end])) {
            ++end;
        }
        const std::string_view longest = text.substr(first, end - first);
        if (longest.size() == code.size() || !validate_code(longest).empty()) {
            return at;
        }
    }
    return std::string_view::npos;
}

/// Names become columns of tables.
bool is_name(std::string_view name) {
    const auto fits = [](char c) {
        return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
               c == '_';
    };
    return !name.empty() && std::ranges::all_of(name, fits);
}

/// Of settings or stimulus values.
template <typename Named> std::string validate_names(const std::vector<Named> &values) {
    for (auto value = values.begin(); value != values.end(); ++value) {
        if (!is_name(value->name)) {
            return in_quotes(value->name) + " is no name: letters, digits and _";
        }
        if (std::find_if(values.begin(), value, [&](const Named &earlier) {
                return earlier.name == value->name;
            }) != value) {
            return in_quotes(value->name) + " is there twice";
        }
    }
    return {};
}

std::string validate_settings(const std::vector<Setting> &settings) {
    for (const Setting &setting : settings) {
        const auto *const number = std::get_if<double>(&setting.value);
        if (number != nullptr && std::isnan(*number)) {
            return in_quotes(setting.name) + " is not a number; leave it out if it is not known";
        }
    }
    return validate_names(settings);
}

std::string validate_place(const TrialPlace &place) {
    return std::min({place.block, place.position, place.attempt}) >= 1
               ? std::string()
               : text_of(place) + ": block, position and attempt are counted from 1";
}

std::string validate_response(const Response &response) {
    if (const auto *const chosen = std::get_if<Chosen>(&response)) {
        return chosen->alternative >= 1 ? "" : "alternatives are counted from 1";
    }
    const auto *const adjusted = std::get_if<Adjusted>(&response);
    return adjusted != nullptr && std::isnan(adjusted->level) ? "the level adjusted is not a number"
                                                              : "";
}

bool is_sha256(std::string_view text) {
    return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == text.npos;
}

std::string first_of(std::initializer_list<std::string> problems) {
    const auto first = std::ranges::find_if_not(problems, &std::string::empty);
    return first == problems.end() ? std::string() : *first;
}

bool is_blank(std::string_view text) { return text.find_first_not_of(" \t\r\n") == text.npos; }

/// Of what people type.
std::string validate_text(std::string_view what, std::string_view text) {
    if (text.size() > kMaxBytesOfText) {
        return fmt::format("{} of {} bytes is longer than {}; shorten it, and keep long texts "
                           "outside of the study",
                           what, text.size(), kMaxBytesOfText);
    }
    return is_utf8(text) ? std::string()
                         : fmt::format("{} is no text in UTF-8; type it anew, in a terminal or "
                                       "program that is set to UTF-8",
                                       what);
}

} // namespace

UtcTime utc_now() {
    return std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
}

std::string utc_text(UtcTime time) {
    const auto day = std::chrono::floor<std::chrono::days>(time);
    const std::chrono::year_month_day date(day);
    const std::chrono::hh_mm_ss clock(time - day);
    const int year = static_cast<int>(date.year());
    SPRINGDRIVE_ASSERT(year >= 0 && year <= 9999);
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", year,
                       static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                       clock.hours().count(), clock.minutes().count(), clock.seconds().count(),
                       clock.subseconds().count());
}

std::optional<UtcTime> utc_time_of(std::string_view text) {
    using namespace std::chrono;
    if (!has_the_form(text)) {
        return std::nullopt;
    }
    const year_month_day date{year(digits<int>(text, 0, 4)), month(digits<unsigned>(text, 5, 2)),
                              day(digits<unsigned>(text, 8, 2))};
    const hours h(digits<int>(text, 11, 2));
    const minutes min(digits<int>(text, 14, 2));
    const seconds s(digits<int>(text, 17, 2));
    if (!date.ok() || h > hours(23) || min > minutes(59) || s > seconds(59)) {
        return std::nullopt;
    }
    return sys_days(date) + h + min + s + milliseconds(digits<int>(text, 20, 3));
}

std::string validate_code(std::string_view code) {
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

bool is_mistaken_for(std::string_view code, std::string_view other) {
    const auto without_zeros = [](std::string_view of) {
        std::string text(of);
        const std::size_t digits = std::min(text.find_first_of("0123456789"), text.size());
        return text.erase(digits, text.find_first_not_of('0', digits) - digits);
    };
    return code != other && without_zeros(code) == without_zeros(other);
}

bool has_code(std::string_view text, std::string_view code) {
    return find_code(text, code, 0) != std::string_view::npos;
}

bool redact_code(std::string &text, std::string_view code) {
    bool had_it = false;
    for (std::size_t at = find_code(text, code, 0); at != std::string::npos;
         at = find_code(text, code, at + kReplacement.size())) {
        text.replace(at, code.size(), kReplacement);
        had_it = true;
    }
    return had_it;
}

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

std::string validate_records_folder(std::string_view name) {
    const std::string problem = validate_file_name(name);
    return !problem.empty() || name.ends_with(".records")
               ? problem
               : in_quotes(name) + " is no folder of records, which ends in .records";
}

std::string validate_record(const Trial &trial, std::string_view records_folder) {
    if (!trial.record) {
        return {};
    }
    const std::filesystem::path folder = std::filesystem::path(records_folder) / trial.participant;
    const std::filesystem::path &path = trial.record->path;
    const auto [in_folder, rest] =
        std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
    if (in_folder != folder.end() || rest == path.end() || !path.has_filename() ||
        path != path.lexically_normal() || !std::all_of(rest, path.end(), [](const auto &part) {
            return validate_file_name(part.native()).empty();
        })) {
        return in_quotes(path.string()) + " is not in the participant's folder of records, " +
               folder.string();
    }
    return is_sha256(trial.record->sha256) ? "" : "the record's SHA-256 is not one";
}

std::string validate(const Participant &participant) {
    return first_of({validate_code(participant.code),
                     participant.number >= 1 ? "" : "participants are numbered from 1"});
}

std::string validate(const Session &session) { return validate_settings(session.facts); }

std::string validate(const Trial &trial, std::string_view records_folder) {
    std::string problem =
        first_of({validate_place(trial.place), validate_settings(trial.tuning),
                  validate_response(trial.response), validate_record(trial, records_folder),
                  std::ranges::find(trial.marks, std::string()) == trial.marks.end()
                      ? ""
                      : "a mark has no reason",
                  trial.is_presented_again && trial.marks.empty()
                      ? "it is presented again, and nothing says why"
                      : ""});
    for (const Presentation &presentation : trial.presentations) {
        problem = first_of({problem, validate_names(presentation.values)});
    }
    return problem.empty() ? problem
                           : fmt::format("trial of {}, {}: {}", in_quotes(trial.participant),
                                         text_of(trial.place), problem);
}

std::string validate(const QuestionnaireAnswer &answer) {
    const std::string problem = first_of(
        {is_name(answer.item) ? "" : in_quotes(answer.item) + " is no name: letters, digits and _",
         is_blank(answer.question) ? "the question has no text" : "",
         validate_text("an answer", answer.answer)});
    return problem.empty()
               ? problem
               : fmt::format("answer of {}: {}", in_quotes(answer.participant), problem);
}

std::string validate(const Note &note) {
    return first_of(
        {note.kind.empty() ? "a note has no kind" : "",
         is_blank(note.text) ? "a note has no text; type some" : "",
         validate_text("a note", note.text),
         note.session && !note.participant ? "a note of a session needs its participant" : ""});
}

} // namespace springdrive::study

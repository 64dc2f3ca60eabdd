#include "engine/study/store/trial_checks.h"

#include "base/contained_path.h"
#include "base/one_line.h"
#include "base/quoting.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace springdrive::study {

namespace {

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

} // namespace

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

namespace {

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

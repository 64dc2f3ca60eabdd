#include "engine/study/export/bids.h"

#include "engine/study/export/answer_table.h"
#include "engine/study/export/trial_table.h"

#include "base/input_error.h"
#include "base/new_file.h"
#include "base/one_line.h"
#include "base/quoting.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <map>
#include <sstream>
#include <system_error>

namespace springdrive::study {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char *kBidsVersion = "1.9.0";

double seconds(UtcTime::duration time) { return std::chrono::duration<double>(time).count(); }

/// From the start of the first presentation to the end of the last, by the servo's clock.
std::optional<double> presented_s(const Trial &trial) {
    if (trial.presentations.empty() || !trial.presentations.front().start_s ||
        !trial.presentations.back().end_s) {
        return std::nullopt;
    }
    return std::max(0.0, *trial.presentations.back().end_s - *trial.presentations.front().start_s);
}

/// Of the trials of one session [s]. A trial does not begin before the one before was answered,
/// whatever the wall clock says: it may be set while a session runs, and knows nothing of the time
/// that passes in a simulated one.
std::vector<double> onsets_s(const std::vector<TrialInStudy> &trials) {
    constexpr double kPerSecond = 1000.0; // of the wall clock
    std::vector<double> onsets_s;
    double answered_s = 0.0;
    for (const TrialInStudy &row : trials) {
        const double lasted_s =
            presented_s(row.trial).value_or(0.0) + row.trial.response_time_s.value_or(0.0);
        const double onset_s =
            std::max(answered_s, seconds(row.trial.at - row.session.started) - lasted_s);
        onsets_s.push_back(std::round(onset_s * kPerSecond) / kPerSecond);
        answered_s = onset_s + lasted_s;
    }
    return onsets_s;
}

const Column kOnset{
    .name = "onset",
    .meaning =
        "from the start of the session to that of the first presentation, by the wall clock: the "
        "end of the trial less response time and presentations, but not before the trial before "
        "was "
        "answered. A simulated session, which passes faster than the clock, is thus a sum of "
        "presentations and response times, without pauses and breaks. Exact times by the servo's "
        "clock are in presentation1_start_s and its like",
    .unit = "s"};

Cell seconds_cell(std::optional<double> number) {
    return number ? Cell::like_number(shortest_text(*number)) : Cell();
}

/// The columns that BIDS defines, after the onset.
std::vector<TrialColumn> bids_columns() {
    return {{{.name = "duration",
              .meaning = "from the start of the first presentation to the end of the last",
              .unit = "s"},
             [](const TrialInStudy &row) { return seconds_cell(presented_s(row.trial)); }},
            {{.name = "trial_type", .meaning = "name of the condition in the protocol"},
             [](const TrialInStudy &row) { return row.trial.condition; }},
            {{.name = "response_time",
              .meaning = "from the end of the last presentation to the response",
              .unit = "s"},
             [](const TrialInStudy &row) { return seconds_cell(row.trial.response_time_s); }}};
}

Json description_of(const Column &column) {
    Json json{{"Description", column.meaning}};
    if (!column.unit.empty()) {
        json["Units"] = column.unit;
    }
    for (const auto &[value, meaning] : column.levels) {
        json["Levels"][value] = meaning;
    }
    return json;
}

/// "Levels" of a scale or choice: each possible answer with its meaning.
Json levels_of(const QuestionnaireItem &item) {
    Json levels;
    for (const std::string &answer : possible_answers(item)) {
        levels[guard_formula(answer)] = answer; // as in the table
    }
    if (item.kind == QuestionnaireKind::scale) {
        levels[std::to_string(item.lowest)] = item.lowest_label;
        levels[std::to_string(item.highest)] = item.highest_label;
    }
    return levels;
}

Json description_of(const std::vector<QuestionnaireItem> &items) {
    Json json{{"MeasurementToolMetadata",
               {{"Description",
                 "Questions of the study's own protocol, asked before a session's first trial and "
                 "after its last"}}},
              {"session_id", {{"Description", "session within the participant"}}}};
    for (const QuestionnaireItem &item : items) {
        Json &column = json[item.name];
        column["LongName"] =
            fmt::format("{} ({} the trials)", item.name,
                        kQuestionnaireTimeNames[static_cast<std::size_t>(item.when)]);
        column["Description"] = item.text;
        if (item.kind != QuestionnaireKind::text) {
            column["Levels"] = levels_of(item);
        }
    }
    return json;
}

/// A new folder, removed unless it is published.
class NewFolder {
public:
    explicit NewFolder(const std::filesystem::path &name)
        : name_(name), temporary_(resolved_name(name).parent_path() / ".springdrive_bids_XXXXXX") {
        std::error_code error;
        if (std::filesystem::exists(std::filesystem::symlink_status(name_, error))) {
            throw InputError(name_.string() + ": exists; give another name");
        }
        std::string made = temporary_.string();
        if (mkdtemp(made.data()) == nullptr) { // for its owner only, as what is in it
            check(std::error_code(errno, std::generic_category()));
        }
        temporary_ = made;
    }
    ~NewFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(temporary_, ignored);
    }
    NewFolder(const NewFolder &) = delete;
    NewFolder &operator=(const NewFolder &) = delete;

    void write(const std::filesystem::path &file, const std::string &text) const {
        check(make_folders_for_owner((temporary_ / file).parent_path()));
        write_file(temporary_ / file, [&](std::ostream &out) { out << text; },
                   {Existing::keep, Readers::owner});
    }
    void write(const std::filesystem::path &file, const Table &table) const {
        std::ostringstream text;
        write_tsv(text, table);
        write(file, text.str());
    }
    void write(const std::filesystem::path &file, const Json &json) const {
        write(file, json_text(json) + '\n');
    }
    void publish() const {
        std::error_code error;
        std::filesystem::rename(temporary_, name_, error);
        check(error);
    }

private:
    void check(const std::error_code &error) const {
        if (error) {
            throw InputError(name_.string() + ": cannot be written: " + error.message() +
                             "; give another name");
        }
    }

    std::filesystem::path name_;
    std::filesystem::path temporary_;
};

Json dataset_description(const StudyContents &contents, const BidsOptions &options) {
    return {
        {"Name", contents.facts.title},
        {"BIDSVersion", kBidsVersion},
        {"DatasetType", "raw"},
        {"GeneratedBy", Json::array({{{"Name", "springdrive"}, {"Version", options.software}}})}};
}

std::string readme(const StudyContents &contents, const BidsOptions &options) {
    std::string devices;
    for (const DeviceKind device : options.devices) {
        devices += std::string(devices.empty() ? "" : ", ") + std::string(name_of(device));
    }
    return fmt::format("{}\n\nExported by springdrive {} from a study created on {}.\nDevices: {}. "
                       "Data of simulated and emulated devices are no person's.\nProtocol: SHA-256 "
                       "{}\n\n{}",
                       contents.facts.title, options.software, utc_text(contents.facts.created),
                       devices, contents.facts.protocol_sha256, contents.facts.protocol);
}

/// The columns of BIDS after the onset, then all others.
std::vector<TrialColumn> all_columns(const StudyContents &contents) {
    std::vector<TrialColumn> columns = bids_columns();
    std::ranges::move(trial_columns(contents), std::back_inserter(columns));
    return columns;
}

Table events_of(const std::vector<TrialColumn> &columns, const std::vector<TrialInStudy> &trials) {
    Table events = table_of(columns, trials);
    events.columns.insert(events.columns.begin(), kOnset);
    const std::vector<double> onsets = onsets_s(trials);
    for (std::size_t i = 0; i < trials.size(); ++i) {
        events.rows[i].insert(events.rows[i].begin(), seconds_cell(onsets[i]));
    }
    return events;
}

} // namespace

std::string bids_task_label(std::string_view title) {
    std::string label;
    std::ranges::copy_if(title, std::back_inserter(label), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    });
    return label.empty() ? "study" : label;
}

void write_bids(const StudyContents &contents, const std::filesystem::path &folder,
                const BidsOptions &options) {
    const std::string task = "task-" + bids_task_label(contents.facts.title);
    const std::vector<TrialColumn> columns = all_columns(contents);
    // By participant, then by session, as BIDS numbers them; without sessions that left nothing.
    std::map<std::string, std::map<SessionId, std::vector<TrialInStudy>>> trials;
    for (const TrialInStudy &trial : trials_in_study(contents, options.devices)) {
        trials[trial.trial.participant][trial.session.id].push_back(trial);
    }
    for (const QuestionnaireAnswer &answer : contents.answers) {
        const DeviceKind device = session_of(contents, answer.session).device;
        if (std::ranges::count(options.devices, device) > 0) {
            trials[answer.participant].try_emplace(answer.session);
        }
    }
    const NewFolder created(folder);
    created.write("dataset_description.json", dataset_description(contents, options));
    created.write("README", readme(contents, options));
    Json sidecar{{"TaskName", contents.facts.title}, {kOnset.name, description_of(kOnset)}};
    for (const TrialColumn &column : columns) {
        sidecar[column.name] = description_of(column);
    }
    sidecar["StimulusPresentation"] = {{"SoftwareName", "springdrive"},
                                       {"SoftwareVersion", contents.facts.software}};
    created.write(task + "_events.json", sidecar);
    Table answers = Table::with_columns("participant_id,session_id");
    for (const QuestionnaireItem &item : options.questionnaire) {
        answers.columns.push_back({item.name});
    }
    Table participants = Table::with_columns("participant_id,number,sessions,trials");
    for (const auto &[code, sessions] : trials) {
        std::size_t count = 0;
        int number = 0;
        for (const auto &[id, of_session] : sessions) {
            const std::string stem = fmt::format("sub-{}_ses-{:02}", code, ++number);
            created.write( // without a row if the session has answers only
                fmt::format("sub-{}/ses-{:02}/beh/{}_{}_events.tsv", code, number, stem, task),
                events_of(columns, of_session));
            std::vector<Cell> row{"sub-" + code, fmt::format("ses-{:02}", number)};
            std::ranges::copy(answers_of(contents, options.questionnaire, id),
                              std::back_inserter(row));
            answers.rows.push_back(std::move(row));
            count += of_session.size();
        }
        participants.rows.push_back(
            {"sub-" + code, participant_of(contents, code).number, number, count});
    }
    created.write("participants.tsv", participants);
    created.write("participants.json",
                  Json{{"number", {{"Description", "number for counterbalancing"}}},
                       {"sessions", {{"Description", "sessions with trials or answers"}}},
                       {"trials", {{"Description", "trials, of all kinds"}}}});
    if (!options.questionnaire.empty()) {
        created.write("phenotype/questionnaire.tsv", answers);
        created.write("phenotype/questionnaire.json", description_of(options.questionnaire));
    }
    created.publish();
}

} // namespace springdrive::study

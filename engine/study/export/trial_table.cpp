#include "engine/study/export/trial_table.h"

#include "base/input_error.h"
#include "base/new_file.h"
#include "base/text.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <map>
#include <sstream>
#include <system_error>

namespace springdrive::study {

namespace {

template <typename Value> Cell cell_of(const Value &value) { return value; }
/// As text, so that an infinite number is written: "inf".
Cell cell_of(double number) {
    return std::isnan(number) ? Cell() : Cell::like_number(shortest_text(number));
}
Cell cell_of(const TrialPlace &place) {
    return fmt::format("{}-{}-{}", place.block, place.position, place.attempt);
}
template <typename Value> Cell cell_of(const std::optional<Value> &value) {
    return value ? cell_of(*value) : Cell();
}

std::string joined(const std::vector<std::string> &texts) {
    std::string all;
    for (const std::string &text : texts) {
        all += (all.empty() ? "" : "; ") + text;
    }
    return all;
}

std::string safety_text(const Trial &trial) {
    std::vector<std::string> texts;
    for (const SafetyEvent &event : trial.safety_events) {
        texts.push_back(event.text);
    }
    return joined(texts);
}

Cell cell_of(const Response &response) {
    if (const auto *const chosen = std::get_if<Chosen>(&response)) {
        return cell_of(chosen->alternative);
    }
    if (const auto *const answer = std::get_if<YesNo>(&response)) {
        return cell_of(answer->yes);
    }
    const auto *const adjusted = std::get_if<Adjusted>(&response);
    return adjusted != nullptr ? cell_of(adjusted->level) : Cell();
}

/// Columns are added one after the other.
class Columns {
public:
    /// @param value  of a TrialInStudy
    template <typename Value>
    TrialColumn &add(std::string name, std::string description, Value &&value) {
        columns.push_back(
            {{.name = std::move(name), .meaning = std::move(description)},
             [value](const TrialInStudy &row) -> Cell { return cell_of(value(row)); }});
        return columns.back();
    }

    std::vector<TrialColumn> columns;
};

using Row = const TrialInStudy &;

void add_whose_and_where(Columns &to) {
    to.add("participant", "code of the participant", [](Row row) { return row.trial.participant; });
    to.add("participant_number", "number of the participant, for counterbalancing",
           [](Row row) { return row.participant.number; });
    to.add("session", "number of the session in the study", [](Row row) { return row.session.id; });
    to.add("device_kind", "what the session ran on",
           [](Row row) { return name_of(row.session.device); })
        .levels = {{"simulated", "no device and no person"},
                   {"emulated", "a simulated device behind an emulated board; no person"},
                   {"usb", "a device on USB"}};
    to.add("device_serial", "serial number of the device",
           [](Row row) { return row.session.device_serial; });
    to.add("block", "block, from 1", [](Row row) { return row.trial.place.block; });
    to.add("position", "position in the block, from 1",
           [](Row row) { return row.trial.place.position; });
    to.add("attempt", "1, or more if the position was repeated",
           [](Row row) { return row.trial.place.attempt; });
}

void add_stimulus_and_response(Columns &to) {
    to.add("condition", "name of the condition in the protocol",
           [](Row row) { return row.trial.condition; });
    to.add("track", "track of the method, such as one of several staircases",
           [](Row row) { return row.trial.track; });
    to.add("is_practice", "1 for a practice trial", [](Row row) { return row.trial.is_practice; });
    to.add("is_catch", "1 for a catch trial", [](Row row) { return row.trial.is_catch; });
    to.add("is_presented_again", "1 if the method did not count it and presents its level again",
           [](Row row) { return row.trial.is_presented_again; });
    to.add("counts", "1 for the analysis: no practice, no catch trial, no mark",
           [](Row row) { return counts(row.trial); });
    // As a text: of a number of 64 bits Excel, R and JavaScript keep 53. R takes 0x… for a number.
    to.add("seed", "key of everything random in the trial: x and 64 bits in hexadecimal",
           [](Row row) { return fmt::format("x{:016x}", row.trial.seed); });
    to.add("level_name", "the variable under test, with its unit",
           [](Row row) { return row.trial.level_name; });
    to.add("level", "its value", [](Row row) { return row.trial.level; });
    to.add("target", "the right alternative, from 1; or 1 yes, 0 no",
           [](Row row) { return row.trial.target; });
    to.add("response_kind", "kind of the response",
           [](Row row) { return kResponseNames[row.trial.response.index()]; })
        .levels = {{"none", "none was given"},
                   {"chosen", "an alternative, from 1"},
                   {"yes_no", "1 yes, 0 no"},
                   {"adjusted", "a level, in the unit of level_name"}};
    to.add("response", "the response, see response_kind",
           [](Row row) { return cell_of(row.trial.response); });
    to.add("is_correct", "1 for a right response", [](Row row) { return row.trial.is_correct; });
    to.add("response_time_s", "from the end of the last presentation to the response", [](Row row) {
          return row.trial.response_time_s;
      }).unit = "s";
}

void add_circumstances(Columns &to) {
    to.add("at_utc", "when the trial ended, ISO 8601, UTC",
           [](Row row) { return utc_text(row.trial.at); });
    to.add("software", "version of the program", [](Row row) { return row.trial.software; });
    to.add("missed_deadlines", "servo ticks that were late",
           [](Row row) { return row.trial.missed_deadlines; });
    to.add("safety_events", "trips of safety monitors",
           [](Row row) { return safety_text(row.trial); });
    to.add("marks", "why the trial does not count",
           [](Row row) { return joined(row.trial.marks); });
    to.add("repetition_of", "block-position-attempt of the trial that it repeats",
           [](Row row) { return row.trial.repetition_of; });
    to.add("repeated_by", "block-position-attempt of the trial that repeats it",
           [](Row row) { return row.trial.repeated_by; });
    to.add("record", "file of the servo record, relative to the study's folder", [](Row row) {
        return row.trial.record ? Cell(row.trial.record->path.string()) : Cell();
    });
    to.add("record_sha256", "SHA-256 of that file",
           [](Row row) { return row.trial.record ? Cell(row.trial.record->sha256) : Cell(); });
}

/// Names in the order of their first appearance.
void note_name(std::vector<std::string> &names, const std::string &name) {
    if (std::ranges::find(names, name) == names.end()) {
        names.push_back(name);
    }
}

/// The value of that name, if it is there.
template <typename Named>
const Named *named(const std::vector<Named> &values, const std::string &name) {
    const auto found = std::ranges::find(values, name, &Named::name);
    return found == values.end() ? nullptr : &*found;
}

const Presentation *presentation(Row row, std::size_t number) {
    return number < row.trial.presentations.size() ? &row.trial.presentations[number] : nullptr;
}

void add_presentation(Columns &to, const StudyContents &contents, std::size_t i) {
    const std::string prefix = fmt::format("presentation{}_", i + 1);
    const std::string which = fmt::format(" of presentation {}", i + 1);
    using Time = std::optional<double> Presentation::*;
    const auto add_time = [&](const char *name, const char *description, Time time) {
        to.add(prefix + name, description + which + ", servo's clock", [i, time](Row row) {
              const Presentation *const one = presentation(row, i);
              return one != nullptr ? one->*time : std::nullopt;
          }).unit = "s";
    };
    add_time("start_s", "start", &Presentation::start_s);
    add_time("end_s", "end", &Presentation::end_s);
    std::vector<std::string> names;
    for (const Trial &trial : contents.trials) {
        if (i < trial.presentations.size()) {
            for (const StimulusValue &value : trial.presentations[i].values) {
                note_name(names, value.name);
            }
        }
    }
    using Number = std::optional<double> StimulusValue::*;
    const auto add_value = [&](const std::string &name, const std::string &what, Number number) {
        to.add(prefix + name + "_" + what, name + which + ", " + what, [i, name, number](Row row) {
            const Presentation *const one = presentation(row, i);
            const StimulusValue *const value = one != nullptr ? named(one->values, name) : nullptr;
            return value != nullptr ? value->*number : std::nullopt;
        });
    };
    for (const std::string &name : names) {
        add_value(name, "intended", &StimulusValue::intended);
        add_value(name, "delivered", &StimulusValue::delivered);
    }
}

void add_own_of_study(Columns &to, const StudyContents &contents) {
    std::size_t presentations = 0;
    std::size_t windings = 0;
    std::vector<std::string> settings;
    for (const Trial &trial : contents.trials) {
        presentations = std::max(presentations, trial.presentations.size());
        windings = std::max(windings, trial.windings_degC.size());
        for (const Setting &setting : trial.tuning) {
            note_name(settings, setting.name);
        }
    }
    for (std::size_t i = 0; i < presentations; ++i) {
        add_presentation(to, contents, i);
    }
    for (std::size_t i = 0; i < windings; ++i) {
        to.add(fmt::format("winding{}_degC", i + 1),
               fmt::format("temperature of the winding of motor {}, at the end", i + 1),
               [i](Row row) {
                   return i < row.trial.windings_degC.size() ? row.trial.windings_degC[i]
                                                             : std::nullopt;
               })
            .unit = "degC";
    }
    for (const std::string &name : settings) {
        to.add("tuning_" + name, name + " of the tuning in force", [name](Row row) {
            const Setting *const setting = named(row.trial.tuning, name);
            return setting == nullptr ? Cell()
                                      : std::visit([](const auto &value) { return cell_of(value); },
                                                   setting->value);
        });
    }
}

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
    Json json{
        {"Name", contents.facts.title}, {"BIDSVersion", kBidsVersion}, {"DatasetType", "raw"}};
    if (!options.authors.empty()) { // an empty list would be as wrong as one with nobody in it
        json["Authors"] = options.authors;
    }
    json["GeneratedBy"] = Json::array({{{"Name", "springdrive"}, {"Version", options.software}}});
    return json;
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

std::vector<TrialColumn> trial_columns(const StudyContents &contents) {
    Columns all;
    add_whose_and_where(all);
    add_stimulus_and_response(all);
    add_circumstances(all);
    add_own_of_study(all, contents);
    return std::move(all.columns);
}

std::vector<TrialInStudy> trials_in_study(const StudyContents &contents,
                                          const std::vector<DeviceKind> &devices) {
    std::vector<TrialInStudy> trials;
    for (const Trial &trial : contents.trials) {
        const Session &session = session_of(contents, trial.session);
        if (std::ranges::find(devices, session.device) != devices.end()) {
            trials.push_back({trial, session, participant_of(contents, trial.participant)});
        }
    }
    return trials;
}

Table table_of(const std::vector<TrialColumn> &columns, const std::vector<TrialInStudy> &trials) {
    Table table{.columns = {columns.begin(), columns.end()}};
    for (const TrialInStudy &trial : trials) {
        std::vector<Cell> &row = table.rows.emplace_back();
        for (const TrialColumn &column : columns) {
            row.push_back(column.cell(trial));
        }
    }
    return table;
}

Table answer_table(const StudyContents &contents, const std::vector<QuestionnaireItem> &items,
                   const std::vector<DeviceKind> &devices) {
    Table table = Table::with_columns("participant,participant_number,session,device_kind,when,"
                                      "item,kind,question,answer,at_utc");
    for (const QuestionnaireAnswer &answer : contents.answers) {
        const Session &session = session_of(contents, answer.session);
        if (std::ranges::count(devices, session.device) == 0) {
            continue;
        }
        const auto item = std::ranges::find(items, answer.item, &QuestionnaireItem::name);
        const bool is_known = item != items.end();
        using Place = std::size_t;
        table.rows.push_back(
            {answer.participant, participant_of(contents, answer.participant).number, session.id,
             name_of(session.device),
             is_known ? kQuestionnaireTimeNames[static_cast<Place>(item->when)] : "", answer.item,
             is_known ? kQuestionnaireKindNames[static_cast<Place>(item->kind)] : "",
             answer.question, answer.answer, utc_text(answer.at)});
    }
    return table;
}

std::vector<std::string> answers_of(const StudyContents &contents,
                                    const std::vector<QuestionnaireItem> &items,
                                    SessionId session) {
    std::vector<std::string> answers(items.size());
    for (const QuestionnaireAnswer &answer : contents.answers) {
        const auto item = std::ranges::find(items, answer.item, &QuestionnaireItem::name);
        if (answer.session == session && item != items.end()) {
            answers[static_cast<std::size_t>(item - items.begin())] = answer.answer;
        }
    }
    return answers;
}

std::vector<QuestionnaireAnswer> answers_on(const StudyContents &contents, DeviceKind device) {
    std::vector<QuestionnaireAnswer> answers;
    std::ranges::copy_if(contents.answers, std::back_inserter(answers),
                         [&](const QuestionnaireAnswer &answer) {
                             return session_of(contents, answer.session).device == device;
                         });
    return answers;
}

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
    // No TaskName, which is of recordings' sidecars: the validator takes it for a column here.
    Json sidecar{{kOnset.name, description_of(kOnset)}};
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

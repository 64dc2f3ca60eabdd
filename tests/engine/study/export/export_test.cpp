// Covers engine/study/export/.
#include "engine/study/export/trial_table.h"

#include "base/input_error.h"
#include "engine/study/store/study_store.h"
#include "tests/engine/study/store/sample_study.h"
#include "tests/support/csv.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <set>
#include <sstream>

namespace springdrive::study {
namespace {

using testing::contents_of;
using testing::fresh_folder;
using testing::kStart;
using testing::parsed_csv;

const std::vector<DeviceKind> kAll{DeviceKind::simulated, DeviceKind::emulated, DeviceKind::usb};

/// A study of two participants, of which the second is a person.
StudyContents sample_contents() {
    const auto file = testing::sample_study(fresh_folder("export"), 2);
    StudyStore store(file);
    for (int participant = 1; participant <= 2; ++participant) {
        for (int number = 1; number <= 20; ++number) {
            store.append(testing::sample_trial(1, participant, number));
        }
    }
    return store.contents();
}

using Lines = std::vector<std::vector<std::string>>;

Lines csv_of(const Table &table) {
    std::ostringstream out;
    write_csv(out, table);
    return parsed_csv(out.str());
}

Lines csv_of_trials(const StudyContents &contents) {
    return csv_of(table_of(trial_columns(contents), trials_in_study(contents, kAll)));
}

std::string cell_in(const Lines &lines, std::size_t row, const std::string &name) {
    const auto column = std::ranges::find(lines[0], name);
    EXPECT_NE(column, lines[0].end()) << name;
    return lines[row + 1].at(static_cast<std::size_t>(column - lines[0].begin()));
}

/// The 64 bits of "x0123456789abcdef".
std::uint64_t key_in(const std::string &text) {
    EXPECT_EQ(text.size(), 17U) << text;
    EXPECT_EQ(text.substr(0, 1), "x") << text;
    std::uint64_t key = 0;
    const auto [end, error] = std::from_chars(text.data() + 1, text.data() + text.size(), key, 16);
    EXPECT_TRUE(error == std::errc() && end == text.data() + text.size()) << text;
    return key;
}

TEST(TrialTable, HoldsEachTrial) {
    const StudyContents contents = sample_contents();
    const Lines lines = csv_of_trials(contents);
    ASSERT_EQ(lines.size(), 41U);
    const auto &names = lines[0];
    EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
    const auto cell = [&](std::size_t trial, const std::string &name) {
        return cell_in(lines, trial, name);
    };
    const auto expect_number = [&](std::size_t trial, const std::string &name,
                                   const std::optional<double> &number) {
        const std::string text = cell(trial, name);
        double read = 0.0;
        if (!number) {
            EXPECT_EQ(text, "") << name;
        } else {
            EXPECT_EQ(std::from_chars(text.data(), text.data() + text.size(), read).ec, std::errc())
                << name << text;
            EXPECT_EQ(read, *number) << name;
        }
    };
    std::size_t values = 0;
    for (std::size_t i = 0; i < contents.trials.size(); ++i) {
        const Trial &trial = contents.trials[i];
        ASSERT_EQ(lines[i + 1].size(), names.size());
        EXPECT_EQ(cell(i, "participant"), trial.participant);
        EXPECT_EQ(cell(i, "participant_number"), trial.participant == "P01" ? "1" : "2");
        EXPECT_EQ(cell(i, "device_kind"), trial.participant == "P01" ? "emulated" : "usb");
        EXPECT_EQ(cell(i, "position"), std::to_string(trial.place.position));
        EXPECT_EQ(cell(i, "condition"), trial.condition);
        EXPECT_EQ(key_in(cell(i, "seed")), trial.seed);
        EXPECT_EQ(cell(i, "counts"), counts(trial) ? "1" : "0");
        EXPECT_EQ(cell(i, "record"), trial.record ? trial.record->path.string() : "");
        expect_number(i, "level", trial.level);
        expect_number(i, "response_time_s", trial.response_time_s);
        expect_number(i, "winding2_degC", trial.windings_degC[1]);
        for (std::size_t p = 0; p < trial.presentations.size(); ++p) {
            const std::string prefix = "presentation" + std::to_string(p + 1) + "_";
            expect_number(i, prefix + "start_s", trial.presentations[p].start_s);
            for (const StimulusValue &value : trial.presentations[p].values) {
                expect_number(i, prefix + value.name + "_intended", value.intended);
                expect_number(i, prefix + value.name + "_delivered", value.delivered);
                ++values;
            }
        }
    }
    EXPECT_GT(values, 20U);
    EXPECT_EQ(cell(9, "repetition_of"), "1-9-1");
    EXPECT_EQ(cell(8, "repeated_by"), "1-9-2");
}

/// A study whose participant and experimenter typed formulas.
StudyContents contents_with_formulas() {
    StudyContents contents = sample_contents();
    contents.trials.resize(1);
    Trial &trial = contents.trials.front();
    trial.condition = "@SUM(A1)";
    trial.marks = {"-2+3", "and"};
    trial.level = -0.5;
    trial.response = Adjusted{-1e-3};
    contents.answers = {{"P01", trial.session, "free", "=A1", "=HYPERLINK(\"http://x\")", kStart},
                        {"P01", trial.session, "tab", "Q?", "\t=1+1", kStart},
                        {"P01", trial.session, "number", "Q?", "-5", kStart}};
    return contents;
}

TEST(Formulas, AreTextsInCsvAndNumbersStayNumbers) {
    const StudyContents contents = contents_with_formulas();
    const Lines lines = csv_of_trials(contents);
    EXPECT_EQ(cell_in(lines, 0, "condition"), "'@SUM(A1)");
    EXPECT_EQ(cell_in(lines, 0, "marks"), "'-2+3; and");
    EXPECT_EQ(cell_in(lines, 0, "level"), "-0.5");
    EXPECT_EQ(cell_in(lines, 0, "response"), "-0.001");
    const Lines rows = csv_of(answer_table(contents, {}, kAll));
    EXPECT_EQ(rows[1][7], "'=A1");
    EXPECT_EQ(rows[1][8], "'=HYPERLINK(\"http://x\")");
    EXPECT_EQ(rows[2][8], "'\t=1+1");
    EXPECT_EQ(rows[3][8], "-5");
}

TEST(Formulas, AreTextsInBidsToo) {
    const auto folder = fresh_folder("bids_formulas");
    const std::vector<QuestionnaireItem> items{
        {.name = "free", .text = "Q?", .kind = QuestionnaireKind::text},
        {.name = "tab", .text = "Q?", .kind = QuestionnaireKind::text},
        {.name = "number", .text = "Q?", .kind = QuestionnaireKind::text}};
    write_bids(contents_with_formulas(), folder / "dataset", {kAll, "1.0", items});
    EXPECT_EQ(contents_of(folder / "dataset/phenotype/questionnaire.tsv"),
              "participant_id\tsession_id\tfree\ttab\tnumber\n"
              "sub-P01\tses-01\t\"'=HYPERLINK(\"\"http://x\"\")\"\t'=1+1\t-5\n");
}

/// The cells of each line; those in quotes as they are.
Lines cells_of_tsv(const std::string &text) {
    Lines lines;
    std::istringstream all(text);
    for (std::string line; std::getline(all, line);) {
        std::vector<std::string> &cells = lines.emplace_back();
        for (std::size_t at = 0; at <= line.size();) {
            const std::size_t end = std::min(line.find('\t', at), line.size());
            cells.push_back(line.substr(at, end - at));
            at = end + 1;
        }
    }
    return lines;
}

/// Spreadsheets and R read what C reads as a number as a double, which has 53 bits.
TEST(TrialTable, HoldsSeedsOfWhichNoReaderMakesANumber) {
    StudyContents contents = sample_contents();
    testing::Draws draws(50);
    for (Trial &trial : contents.trials) {
        trial.seed = draws.bits() >> draws.below(64); // 17e53 must not become a number, either
    }
    contents.trials[0].seed = 0;
    contents.trials[1].seed = ~std::uint64_t{0};
    contents.trials[2].seed = 0x17e5300000000000U;
    const Lines csv = csv_of_trials(contents);
    std::ostringstream tsv;
    write_tsv(tsv, table_of(trial_columns(contents), trials_in_study(contents, kAll)));
    const Lines of_bids = cells_of_tsv(tsv.str());
    for (std::size_t i = 0; i < contents.trials.size(); ++i) {
        for (const Lines *const lines : {&csv, &of_bids}) {
            const std::string text = cell_in(*lines, i, "seed");
            EXPECT_EQ(key_in(text), contents.trials[i].seed);
            char *end = nullptr;
            static_cast<void>(std::strtod(text.c_str(), &end));
            EXPECT_EQ(end, text.c_str()) << text;
        }
    }
}

TEST(Bids, IsItsOwnersAlone) {
    const testing::Umask umask(0022);
    const auto dataset = fresh_folder("bids_modes") / "dataset";
    write_bids(sample_contents(), dataset, {kAll, "1.0", {}});
    EXPECT_EQ(testing::mode_of(dataset), 0700U);
    int files = 0;
    for (const auto &entry : std::filesystem::recursive_directory_iterator(dataset)) {
        EXPECT_EQ(testing::mode_of(entry.path()), entry.is_directory() ? 0700U : 0600U)
            << entry.path();
        ++files;
    }
    EXPECT_GT(files, 5);
}

/// A study with a single trial of a person: 1.5 s and 1.0 s long, a pause of 0.5 s, a response
/// after 0.75 s, 100 s after the session's start.
StudyContents plain_contents() {
    StudyContents contents;
    contents.facts = {"Direction of a blow", "[study]", std::string(64, '0'), kStart, "0.1.0",
                      "direction.records",   0};
    contents.participants = {{"P01", 1, kStart}};
    Session session = testing::sample_session(2);
    session.id = 1;
    session.participant = "P01";
    session.started = kStart;
    contents.sessions = {session};
    Trial trial;
    trial.participant = "P01";
    trial.session = 1;
    trial.condition = "a\t\"tab\"";
    trial.at = kStart + std::chrono::seconds(100);
    trial.presentations = {{20.0, 21.5, {{"direction_deg", 0.0, 0.25}}}, {22.0, 23.0, {}}};
    trial.response = Chosen{2};
    trial.response_time_s = 0.75;
    contents.trials = {trial};
    return contents;
}

TEST(Bids, IsADataset) {
    const auto folder = fresh_folder("bids") / "out";
    write_bids(plain_contents(), folder, {.software = "0.2.0"});
    std::set<std::string> files;
    for (const auto &entry : std::filesystem::recursive_directory_iterator(folder)) {
        if (entry.is_regular_file()) {
            files.insert(std::filesystem::relative(entry.path(), folder).string());
        }
    }
    const std::string events = "sub-P01/ses-01/beh/sub-P01_ses-01_task-Directionofablow_events.tsv";
    EXPECT_EQ(files, (std::set<std::string>{"README", "dataset_description.json",
                                            "participants.json", "participants.tsv", events,
                                            "task-Directionofablow_events.json"}));
    EXPECT_EQ(contents_of(folder / "participants.tsv"),
              "participant_id\tnumber\tsessions\ttrials\nsub-P01\t1\t1\t1\n");
    const auto json = [&](const char *name) {
        return nlohmann::json::parse(contents_of(folder / name));
    };
    const auto description = json("dataset_description.json");
    EXPECT_EQ(description["Name"], "Direction of a blow");
    EXPECT_EQ(description["BIDSVersion"], "1.9.0");
    EXPECT_EQ(description["DatasetType"], "raw");
    EXPECT_EQ(description["GeneratedBy"][0]["Name"], "springdrive");
    EXPECT_FALSE(description.contains("Authors")) << "nobody has been named";

    const std::string text = contents_of(folder / events);
    // 100 - 0.75 - (23 - 20) s
    EXPECT_TRUE(text.starts_with("onset\tduration\ttrial_type\tresponse_time\tparticipant\t"));
    EXPECT_NE(text.find("\n96.25\t3\t\"a \"\"tab\"\"\"\t0.75\tP01\t1\t1\tusb\t0417\t1\t1\t1\t"),
              std::string::npos)
        << text;
    EXPECT_EQ(text.find("\t\t"), std::string::npos); // no empty cell
    // Each column is described, and each description is of a column.
    const auto sidecar = json("task-Directionofablow_events.json");
    std::set<std::string> columns{"StimulusPresentation"};
    std::istringstream header(text.substr(0, text.find('\n')));
    for (std::string name; std::getline(header, name, '\t');) {
        columns.insert(name);
        EXPECT_NE(sidecar[name].value("Description", ""), "") << name;
    }
    EXPECT_EQ(sidecar.size(), columns.size());
    EXPECT_EQ(sidecar["onset"]["Units"], "s");
    EXPECT_EQ(sidecar["device_kind"]["Levels"].size(), 3U);
}

/// Trials of a session of which the wall clock says nothing, or what cannot be.
TEST(Bids, HasOnsetsThatRiseFromTheSessionsStart) {
    using namespace std::chrono_literals;
    StudyContents contents = plain_contents();
    contents.trials.resize(1);
    contents.trials[0].response_time_s = 0.75;
    contents.trials[0].presentations = {{20.0, 21.0, {}}, {22.0, 23.0, {}}};
    for (const auto after : {1ms, 2ms, 2ms, 100'000ms, 60'000ms}) { // simulated, awake, set back
        contents.trials.push_back(contents.trials[0]);
        contents.trials.back().at = contents.sessions[0].started + after;
        contents.trials.back().place.position = static_cast<int>(contents.trials.size());
    }
    contents.trials.erase(contents.trials.begin());
    const auto folder = fresh_folder("bids_onsets") / "out";
    write_bids(contents, folder, {.software = "0.2.0"});
    std::istringstream lines(
        contents_of(folder / "sub-P01/ses-01/beh/sub-P01_ses-01_task-Directionofablow_events.tsv"));
    std::vector<std::string> onsets;
    for (std::string line; std::getline(lines, line);) {
        onsets.push_back(line.substr(0, line.find('\t')));
    }
    // Each lasts 3 s and is answered 0.75 s later; the fourth as by the clock, 100 - 3.75.
    EXPECT_EQ(onsets, (std::vector<std::string>{"onset", "0", "3.75", "7.5", "96.25", "100"}));
}

const std::vector<QuestionnaireItem> kQuestions{
    {.name = "hand",
     .when = QuestionnaireTime::before,
     .text = "Which hand?",
     .kind = QuestionnaireKind::choice,
     .choices = {"right", "left, mostly"}},
    {.name = "tiring",
     .when = QuestionnaireTime::after,
     .text = "How tiring?",
     .kind = QuestionnaireKind::scale,
     .lowest = 1,
     .highest = 3,
     .lowest_label = "not",
     .highest_label = "very"},
    {.name = "remarks", .when = QuestionnaireTime::after, .text = "Anything else, \"so\"?"}};

/// Two sessions of P01 on USB with a trial each, and one of P02 on a simulated device; two answers
/// of the first, one of each other, one of them to an item that is not in the protocol.
StudyContents answered_contents() {
    StudyContents contents = plain_contents();
    contents.participants.push_back({"P02", 2, kStart});
    contents.sessions.push_back(contents.sessions[0]);
    contents.sessions[1].id = 2;
    contents.sessions.push_back(contents.sessions[0]);
    contents.sessions[2].id = 3;
    contents.sessions[2].participant = "P02";
    contents.sessions[2].device = DeviceKind::simulated;
    for (const int session : {2, 3}) {
        contents.trials.push_back(contents.trials[0]);
        contents.trials.back().session = session;
        contents.trials.back().place.position = session;
        contents.trials.back().participant = session == 3 ? "P02" : "P01";
    }
    contents.answers = {{"P01", 1, "hand", "Which hand?", "left, mostly", kStart},
                        {"P01", 1, "remarks", "Anything else, \"so\"?", "a\t\"b\"\nc", kStart},
                        {"P01", 2, "tiring", "How tiring?", "3", kStart},
                        {"P02", 3, "mood", "How are you?", "fine", kStart}};
    return contents;
}

TEST(AnswerTable, HasARowAnAnswer) {
    const std::string at = utc_text(kStart);
    EXPECT_EQ(csv_of(answer_table(answered_contents(), kQuestions, kAll)),
              (Lines{{"participant", "participant_number", "session", "device_kind", "when", "item",
                      "kind", "question", "answer", "at_utc"},
                     {"P01", "1", "1", "usb", "before", "hand", "choice", "Which hand?",
                      "left, mostly", at},
                     {"P01", "1", "1", "usb", "after", "remarks", "text", "Anything else, \"so\"?",
                      "a\t\"b\"\nc", at},
                     {"P01", "1", "2", "usb", "after", "tiring", "scale", "How tiring?", "3", at},
                     {"P02", "2", "3", "simulated", "", "mood", "", "How are you?", "fine", at}}));
    const Lines people = csv_of(answer_table(answered_contents(), kQuestions, {DeviceKind::usb}));
    EXPECT_EQ(people.size(), 4U);
    EXPECT_EQ(std::ranges::count(people, "P02", [](const auto &line) { return line[0]; }), 0);
    EXPECT_EQ(answers_on(answered_contents(), DeviceKind::simulated).size(), 1U);
    EXPECT_TRUE(answers_on(answered_contents(), DeviceKind::emulated).empty());
}

TEST(Bids, HasAnswersAsPhenotype) {
    const auto folder = fresh_folder("bids_answers") / "out";
    write_bids(answered_contents(), folder, {.questionnaire = kQuestions});
    // By https://bids-specification.readthedocs.io, "Phenotypic and assessment data".
    EXPECT_EQ(contents_of(folder / "phenotype/questionnaire.tsv"),
              "participant_id\tsession_id\thand\ttiring\tremarks\n"
              "sub-P01\tses-01\tleft, mostly\tn/a\t\"a \"\"b\"\" c\"\n"
              "sub-P01\tses-02\tn/a\t3\tn/a\n");
    const auto json = nlohmann::json::parse(contents_of(folder / "phenotype/questionnaire.json"));
    EXPECT_EQ(json["hand"]["Description"], "Which hand?");
    EXPECT_EQ(json["hand"]["LongName"], "hand (before the trials)");
    EXPECT_EQ(json["hand"]["Levels"],
              (nlohmann::json{{"right", "right"}, {"left, mostly", "left, mostly"}}));
    EXPECT_EQ(json["tiring"]["Levels"], (nlohmann::json{{"1", "not"}, {"2", "2"}, {"3", "very"}}));
    EXPECT_FALSE(json["remarks"].contains("Levels"));
    EXPECT_NE(json["MeasurementToolMetadata"].value("Description", ""), "");
    // A row of a participant of the dataset, a folder of each session, a description of each
    // column.
    EXPECT_NE(contents_of(folder / "participants.tsv").find("sub-P01\t"), std::string::npos);
    EXPECT_TRUE(std::filesystem::is_directory(folder / "sub-P01/ses-02"));
    EXPECT_EQ(json.size(), 5U);
}

/// Who is resumed is not asked again, so that an answer may be all that a session left.
TEST(Bids, HasTheAnswersOfSessionsWithoutTrials) {
    StudyContents contents = answered_contents();
    std::erase_if(contents.trials, [](const Trial &trial) { return trial.session == 1; });
    const auto folder = fresh_folder("bids_only_answers") / "out";
    write_bids(contents, folder, {.questionnaire = kQuestions});
    EXPECT_EQ(contents_of(folder / "phenotype/questionnaire.tsv"),
              "participant_id\tsession_id\thand\ttiring\tremarks\n"
              "sub-P01\tses-01\tleft, mostly\tn/a\t\"a \"\"b\"\" c\"\n"
              "sub-P01\tses-02\tn/a\t3\tn/a\n");
    EXPECT_NE(contents_of(folder / "participants.tsv").find("sub-P01\t1\t2\t1\n"),
              std::string::npos);
    // Each participant and session of a table is a folder, too.
    const auto events = [&folder](const std::string &session) {
        return contents_of(folder / "sub-P01" / session / "beh" /
                           ("sub-P01_" + session + "_task-" +
                            bids_task_label(answered_contents().facts.title) + "_events.tsv"));
    };
    EXPECT_EQ(std::ranges::count(events("ses-01"), '\n'), 1) << "the header";
    EXPECT_EQ(std::ranges::count(events("ses-02"), '\n'), 2);
    std::erase_if(contents.answers,
                  [](const QuestionnaireAnswer &answer) { return answer.session == 1; });
    const auto without = fresh_folder("bids_left_nothing") / "out";
    write_bids(contents, without, {.questionnaire = kQuestions});
    EXPECT_TRUE(std::filesystem::exists(without / "sub-P01/ses-01"))
        << "that of the second session";
    EXPECT_FALSE(std::filesystem::exists(without / "sub-P01/ses-02"));
}

TEST(Bids, TakesOnlyTheDevicesAskedFor) {
    const StudyContents contents = sample_contents();
    EXPECT_EQ(trials_in_study(contents, {DeviceKind::simulated}).size(), 0U);
    EXPECT_EQ(trials_in_study(contents, {DeviceKind::usb}).size(), 20U);
    for (const TrialInStudy &trial : trials_in_study(contents, {DeviceKind::usb})) {
        EXPECT_EQ(trial.participant.code, "P02");
    }
    const auto parent = fresh_folder("bids_devices");
    write_bids(contents, parent / "usb", {});
    EXPECT_FALSE(std::filesystem::exists(parent / "usb/sub-P01"));
    EXPECT_TRUE(std::filesystem::exists(parent / "usb/sub-P02/ses-01/beh"));
    write_bids(contents, parent / "emulated", {.devices = {DeviceKind::emulated}});
    EXPECT_TRUE(std::filesystem::exists(parent / "emulated/sub-P01"));
    EXPECT_FALSE(std::filesystem::exists(parent / "emulated/sub-P02"));
}

TEST(Bids, IsWrittenWholeOrNotAtAll) {
    const auto parent = fresh_folder("bids_whole");
    std::filesystem::create_directory(parent / "out");
    const auto said = [&](const char *name) {
        return error_text_of([&] { write_bids(plain_contents(), parent / name, {}); });
    };
    EXPECT_EQ(said("out").find((parent / "out").string() + ": exists"), 0U);
    EXPECT_EQ(said("none/out").find((parent / "none/out").string() + ": cannot be written: No"),
              0U);
    std::filesystem::remove(parent / "out");
    {
        const testing::FullDisk full(300);
        EXPECT_NE(said("out"), "");
    }
    EXPECT_TRUE(std::filesystem::is_empty(parent));
    write_bids(plain_contents(), parent / "out", {});
}

TEST(Bids, NamesATaskByLettersAndDigits) {
    EXPECT_EQ(bids_task_label("Direction of a blow, 2nd"), "Directionofablow2nd");
    EXPECT_EQ(bids_task_label("η"), "study");
}

} // namespace
} // namespace springdrive::study

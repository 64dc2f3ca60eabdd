// Covers engine/study/store/{study_store,rows,study_contents}.cpp, and what the store does with
// studies from people who mean harm.
#include "base/input_error.h"
#include "engine/study/store/study_store.h"
#include "tests/engine/study/store/forged_study.h"
#include "tests/engine/study/store/sample_study.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::study {
namespace {

using namespace std::string_literals;
using testing::are_identical;
using testing::contents_of;
using testing::ForgedStudy;
using testing::fresh_folder;
using testing::kStart;
using testing::mode_of;
using testing::said_on_opening;
using testing::said_on_reading;
using testing::sample_session;
using testing::sample_study;
using testing::sample_trial;
using testing::sample_trials;

TEST(StudyStore, HoldsANewStudy) {
    const auto file = fresh_folder("study_new") / "direction.study";
    create_study(file, testing::sample_new_study(), kStart);
    const StudyContents contents = read_study(file);
    EXPECT_EQ(contents.facts.title, "direction of a force");
    EXPECT_EQ(contents.facts.protocol, testing::sample_new_study().protocol);
    EXPECT_EQ(contents.facts.software, "0.1.0");
    EXPECT_EQ(contents.facts.created, kStart);
    EXPECT_EQ(contents.facts.records_folder, "direction.records");
    // As `printf '[study]\ntitle = "direction of a force"\n' | sha256sum` prints it.
    EXPECT_EQ(contents.facts.protocol_sha256,
              "39823eb9b30ab4af5d41e8bdf7ded81aec44dbf5ec5a83bd552ad21d5d842b12");
    EXPECT_TRUE(contents.participants.empty() && contents.sessions.empty() &&
                contents.trials.empty() && contents.notes.empty());
    EXPECT_EQ(next_participant_number(contents), 1);
}

TEST(StudyStore, IsNeverReplaced) {
    const auto folder = fresh_folder("study_again");
    const auto file = sample_study(folder);
    const StudyContents before = read_study(file);
    EXPECT_EQ(error_text_of([&] { create_study(file, testing::sample_new_study(), kStart); }),
              file.string() + ": exists already; a study is never replaced: give another name");
    EXPECT_EQ(read_study(file), before);
    std::filesystem::remove(file);
    std::ofstream(file.string() + "-journal") << "of another study";
    EXPECT_EQ(error_text_of([&] {
                  create_study(file, testing::sample_new_study(), kStart);
              }).find(file.string() + "-journal: belongs to a study that was here"),
              0U);
}

/// Two stores are given the same; one is of a file.
TEST(StudyStore, InMemoryHoldsWhatAFileDoesAndIsInNoFile) {
    const auto folder = fresh_folder("study_in_memory");
    StudyStore on_disk(sample_study(folder));
    StudyStore in_memory = StudyStore::in_memory(testing::sample_new_study(), kStart);
    in_memory.add(on_disk.contents().participants.front());
    const SessionId session = in_memory.begin(sample_session(1));
    in_memory.end(session, SessionEnding::completed, kStart + std::chrono::hours(2));
    for (int number = 1; number <= 20; ++number) {
        Trial trial = sample_trial(1, 1, number);
        trial.record.reset();
        EXPECT_EQ(on_disk.append(trial), Appended::now);
        EXPECT_EQ(in_memory.append(trial), Appended::now);
        EXPECT_EQ(in_memory.append(trial), Appended::before);
    }
    StudyContents expected = on_disk.contents();
    StudyContents held = in_memory.contents();
    EXPECT_TRUE(are_identical(held.trials, expected.trials));
    EXPECT_EQ(held.participants, expected.participants);
    EXPECT_EQ(held.sessions, expected.sessions);
    EXPECT_TRUE(in_memory.file().empty());
    EXPECT_NE(error_text_of([&] {
                  static_cast<void>(in_memory.new_record_file("P01", {1, 1, 1}));
              }),
              "");
    EXPECT_NE(error_text_of([&] { in_memory.remove_participant("P01"); }), "");
    EXPECT_EQ(StudyStore::in_memory(testing::sample_new_study(), kStart).contents().trials.size(),
              0U)
        << "each is a study of its own";
}

TEST(StudyStore, ReadsTrialsBackBitForBit) {
    constexpr int kTrials = 100;
    const auto file = sample_study(fresh_folder("study_bits"), 2);
    StudyStore store(file);
    for (int number = 1; number <= kTrials; ++number) {
        EXPECT_EQ(store.append(sample_trial(1, 1, number)), Appended::now);
    }
    const auto expected = sample_trials(1, 1, kTrials);
    EXPECT_TRUE(are_identical(store.contents().trials, expected));
    EXPECT_TRUE(are_identical(read_study(file).trials, expected));
}

TEST(StudyStore, StoresNotANumberAsNotKnown) {
    const auto file = sample_study(fresh_folder("study_nan"));
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    StudyStore store(file);
    Trial trial = sample_trial(1, 1, 1);
    trial.level = kNaN;
    trial.presentations = {{kNaN, 1.0, {{"stiffness_N_per_m", 500.0, kNaN}}}};
    EXPECT_EQ(store.append(trial), Appended::now);
    EXPECT_EQ(store.append(trial), Appended::before);
    trial.level.reset();
    trial.presentations = {{std::nullopt, 1.0, {{"stiffness_N_per_m", 500.0, std::nullopt}}}};
    EXPECT_TRUE(are_identical(read_study(file).trials, {trial}));
}

TEST(StudyStore, DoesNotStoreATrialTwice) {
    const auto file = sample_study(fresh_folder("study_twice"), 2);
    StudyStore store(file);
    const Trial trial = sample_trial(1, 1, 3);
    EXPECT_EQ(store.append(trial), Appended::now);
    EXPECT_EQ(store.append(trial), Appended::before);
    Trial other = trial;
    other.level = 17.0;
    EXPECT_EQ(error_text_of([&] { store.append(other); }),
              file.string() + ": has another trial of P01 already: block 1, position 3, attempt 1");
    EXPECT_TRUE(are_identical(store.contents().trials, {trial}));
    // The same place of another participant.
    EXPECT_EQ(store.append(sample_trial(1, 2, 3)), Appended::now);
    EXPECT_EQ(store.contents().trials.size(), 2U);
}

TEST(StudyStore, CountsNoTrialThatIsMarked) {
    Trial trial = sample_trial(1, 1, 1);
    trial.marks.clear();
    trial.is_practice = trial.is_catch = false;
    EXPECT_TRUE(counts(trial));
    trial.marks = {"participant sneezed", "and again"};
    const auto file = sample_study(fresh_folder("study_marks"));
    StudyStore(file).append(trial);
    EXPECT_TRUE(are_identical(read_study(file).trials, {trial}));
    EXPECT_FALSE(counts(read_study(file).trials[0]));
}

TEST(StudyStore, HoldsSessionsAndNotes) {
    const auto file = fresh_folder("study_sessions") / "a.study";
    create_study(file, testing::sample_new_study(), kStart);
    std::vector<Session> expected;
    const std::vector<Note> notes{{kStart, "note", "the room is warm", std::nullopt, std::nullopt},
                                  {kStart, "pause", "drank water", "P01", std::nullopt},
                                  {kStart, "safety", "force 9.1 N", "P01", 1}};
    {
        StudyStore store(file);
        store.add({"P01", 1, kStart});
        for (std::size_t i = 0; i < kSessionEndingNames.size(); ++i) {
            expected.push_back(sample_session(1));
            expected.back().id = store.begin(expected.back());
            expected.back().ended = kStart + std::chrono::minutes(i);
            expected.back().ending = static_cast<SessionEnding>(i);
            store.end(expected.back().id, *expected.back().ending, *expected.back().ended);
        }
        EXPECT_EQ(error_text_of([&] { store.end(1, SessionEnding::stopped, kStart); }),
                  file.string() + ": has no session 1 that runs");
        EXPECT_EQ(error_text_of([&] { static_cast<void>(store.begin(sample_session(2))); }),
                  file.string() +
                      ": has no participant 'P02'; springdrive study status lists them");
        expected.push_back(sample_session(1));
        expected.back().id = store.begin(expected.back());
        for (const Note &note : notes) {
            store.append(note);
        }
        EXPECT_EQ(read_study(file).sessions, expected);
    }
    // The last one was not ended.
    expected.back().ending = SessionEnding::interrupted;
    EXPECT_EQ(StudyStore(file).contents().sessions, expected);
    EXPECT_EQ(read_study(file).notes, notes);
}

TEST(StudyStore, HoldsAnswers) {
    const auto file = sample_study(fresh_folder("study_answers"), 2);
    const std::vector<QuestionnaireAnswer> answers{
        {"P01", 1, "hand", "Which hand?", "left", kStart},
        {"P01", 1, "tiring", "How tiring?", "5", kStart + std::chrono::milliseconds(1)},
        {"P02", 2, "remarks", "Sonst noch etwas?", "two\nlines, \"quoted\"; η", kStart},
        {"P02", 2, "hand", "Which hand?", "", kStart}};
    {
        StudyStore store(file);
        for (const QuestionnaireAnswer &answer : answers) {
            EXPECT_EQ(store.add(answer), Appended::now);
            EXPECT_EQ(read_study(file).answers.back(), answer) << "on the disk at once";
        }
        // Again, as after a crash: the time is that of the first.
        QuestionnaireAnswer again = answers[1];
        again.at += std::chrono::hours(1);
        EXPECT_EQ(store.add(again), Appended::before);
        again.answer = "4";
        EXPECT_EQ(error_text_of([&] { store.add(again); }),
                  file.string() + ": has another answer of P01 to 'tiring' already, in session 1");
        again = answers[1];
        again.question = "How tiring was it?";
        EXPECT_NE(error_text_of([&] { store.add(again); }), "");
        // Another session may be asked the same.
        QuestionnaireAnswer later = answers[0];
        later.session = store.begin(sample_session(1));
        EXPECT_EQ(store.add(later), Appended::now);
        EXPECT_EQ(store.contents().answers.size(), 5U);
    }
    StudyContents contents = StudyStore(file).contents();
    contents.answers.pop_back();
    EXPECT_EQ(contents.answers, answers);
}

TEST(StudyStore, RefusesAnswersThatCannotBe) {
    const auto file = sample_study(fresh_folder("study_answers_refused"), 2);
    StudyStore store(file);
    for (const auto &[answer, part] : std::vector<std::pair<QuestionnaireAnswer, std::string>>{
             {{"P03", 1, "hand", "Which hand?", "left", kStart}, "has no participant 'P03'"},
             {{"P01", 2, "hand", "Which hand?", "left", kStart}, "has no session 2 of"},
             {{"P01", 1, "", "Which hand?", "left", kStart}, "'' is no name"},
             {{"P01", 1, "a,b", "Which hand?", "left", kStart}, "'a,b' is no name"},
             {{"P01", 1, "hand", " \n", "left", kStart}, "question has no text"},
             {{"P01", 1, "hand", "Which hand?", "l\xff", kStart}, "no text in UTF-8"}}) {
        const QuestionnaireAnswer &added = answer; // what a lambda captures
        const std::string said = error_text_of([&] { store.add(added); });
        EXPECT_TRUE(said.starts_with(file.string() + ": ")) << said;
        EXPECT_NE(said.find(part), std::string::npos) << said;
    }
    EXPECT_TRUE(store.contents().answers.empty());
}

TEST(StudyStore, TakesNotesOfSensibleTextOnly) {
    const auto file = sample_study(fresh_folder("study_notes"), 1);
    StudyStore store(file);
    const auto refusal = [&](const std::string &text) {
        const std::string said = error_text_of([&] {
            store.append({kStart, "note", text, std::nullopt, std::nullopt});
        });
        return said.empty() ? said : said.substr(file.string().size() + 2);
    };
    // What Unicode's table 3-7 leaves out: cut, longer than need be, half of a pair, too large.
    for (const char *const text :
         {"\x80", "a\xc3", "\xc3(", "\xc0\xaf", "\xc1\xbf", "\xe0\x9f\xbf", "\xed\xa0\x80",
          "\xf0\x8f\xbf\xbf", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff", "\xe2\x82"}) {
        EXPECT_NE(refusal(text).find("no text in UTF-8"), std::string::npos) << text;
    }
    EXPECT_NE(refusal(std::string(10'001, 'a')).find("longer than 10000"), std::string::npos);
    EXPECT_TRUE(store.contents().notes.empty());
    // The first and last characters of each length, and those beside the pairs.
    const std::vector<std::string> sound{
        "a\x7f", "\xc2\x80 \xdf\xbf", "\xe0\xa0\x80 \xed\x9f\xbf \xee\x80\x80 \xef\xbf\xbf",
        "\xf0\x90\x80\x80 \xf4\x8f\xbf\xbf", std::string(10'000, 'a')};
    for (const std::string &text : sound) {
        EXPECT_EQ(refusal(text), "");
        EXPECT_EQ(store.contents().notes.back().text, text);
    }
}

TEST(StudyStore, TellsTheDevicesApart) {
    const auto file = sample_study(fresh_folder("study_devices"), 3);
    StudyStore store(file);
    for (int participant = 1; participant <= 3; ++participant) {
        for (int number = 1; number <= participant; ++number) {
            store.append(sample_trial(1, participant, number));
        }
    }
    const StudyContents contents = store.contents();
    EXPECT_EQ(trials_on(contents, DeviceKind::emulated).size(), 1U);
    EXPECT_EQ(trials_on(contents, DeviceKind::usb).size(), 2U);
    EXPECT_EQ(trials_on(contents, DeviceKind::simulated).size(), 3U);
    EXPECT_EQ(participant_of(contents, "P02").number, 2);
    EXPECT_EQ(next_participant_number(contents), 4);
    EXPECT_NE(error_text_of([&] { static_cast<void>(participant_of(contents, "P04")); }), "");
    EXPECT_NE(error_text_of([&] { static_cast<void>(session_of(contents, 4)); }), "");
}

TEST(StudyStore, FindsCodesInTexts) {
    for (const auto &[text, redacted] : std::vector<std::pair<std::string, std::string>>{
             {"P01", "[removed]"},
             {"p01 and P01's hand", "[removed] and [removed]'s hand"},
             {"P01P01", "[removed][removed]"},
             {"handP01_left", "hand[removed]_left"},
             {"CONTACTP01", "CONTACT[removed]"}, // no code: too many letters
             {"P01234", "[removed]234"},         // too many digits
             {"P012 XP01 P0 01 P 01", "P012 XP01 P0 01 P 01"},
             {"P012P01", "P012[removed]"},
             {"", ""}}) {
        std::string text_left = text;
        EXPECT_EQ(redact_code(text_left, "P01"), text != redacted) << text;
        EXPECT_EQ(text_left, redacted);
        EXPECT_EQ(has_code(text, "P01"), text != redacted) << text;
    }
}

TEST(StudyStore, TakesCodesOnly) {
    for (const char *const code : {"P1", "P01", "VP1234", "ABC0001"}) {
        EXPECT_EQ(validate_code(code), "") << code;
    }
    for (const char *const name : {"", "P", "01", "Anna", "ANNA01", "P01 ", " P01", "p01", "P01A",
                                   "P12345", "P-01", "P01\n", "../P01", "ÄP01", "Anna Müller"}) {
        EXPECT_NE(validate_code(name), "") << name;
    }
    const auto file = sample_study(fresh_folder("study_codes"));
    StudyStore store(file);
    for (const auto &[participant, part] : std::vector<std::pair<Participant, std::string>>{
             {{"Anna", 2, kStart}, "'Anna' is no participant's code"},
             {{"P01", 2, kStart}, "has a participant P01 already"},
             {{"P02", 1, kStart}, "has a participant of number 1 already: P01"},
             {{"P1", 2, kStart}, "has a participant P01, for whom P1"},
             {{"P001", 2, kStart}, "has a participant P01, for whom P001"},
             {{"P02", 0, kStart}, "participants are numbered from 1"}}) {
        const Participant &added = participant; // what a lambda captures
        EXPECT_EQ(error_text_of([&] { store.add(added); }).find(file.string() + ": " + part), 0U)
            << part;
    }
    EXPECT_EQ(read_study(file).participants.size(), 1U);
}

TEST(StudyStore, KnowsCodesThatDifferByZerosAlone) {
    testing::Draws draws(50);
    for (int i = 0; i < 500; ++i) {
        const std::string letters(1 + draws.below(std::size_t{3}),
                                  static_cast<char>('A' + draws.below(26)));
        const int number = draws.below(draws.coin() ? 10000 : 100);
        const std::string digits = std::to_string(number);
        std::vector<std::string> codes;
        for (std::size_t zeros = 0; zeros + digits.size() <= 4; ++zeros) {
            codes.push_back(letters + std::string(zeros, '0') + digits);
        }
        for (const std::string &code : codes) {
            EXPECT_EQ(validate_code(code), "");
            for (const std::string &other : codes) {
                EXPECT_EQ(is_mistaken_for(code, other), code != other) << code << ' ' << other;
            }
            EXPECT_FALSE(is_mistaken_for(code, letters + std::to_string(number + 1)));
            EXPECT_FALSE(is_mistaken_for(code, (letters == "A" ? "B" : "A") + digits));
            EXPECT_FALSE(is_mistaken_for(code, code + "0") && number != 0) << code;
        }
    }
}

TEST(StudyStore, RefusesTrialsThatCannotBe) {
    const auto file = sample_study(fresh_folder("study_refused"), 2);
    StudyStore store(file);
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    const auto expect_refused = [&](const auto &change, const std::string &part) {
        Trial trial = sample_trial(1, 1, 1);
        change(trial);
        const std::string said = error_text_of([&] { store.append(trial); });
        EXPECT_TRUE(said.starts_with(file.string() + ": ")) << said;
        EXPECT_NE(said.find(part), std::string::npos) << said;
    };
    expect_refused(
        [](Trial &trial) {
            trial.participant = "P03";
            trial.record.reset();
        },
        "has no participant 'P03'");
    expect_refused([](Trial &trial) { trial.session = 2; }, "has no session 2 of");
    expect_refused([](Trial &trial) { trial.session = 9; }, "has no session 9 of");
    expect_refused(
        [](Trial &trial) {
            trial.repetition_of = TrialPlace{1, 7, 1};
        },
        "has no trial of P01 to be repeated: block 1, position 7, attempt 1");
    expect_refused([](Trial &trial) { trial.place.attempt = 0; }, "are counted from 1");
    const std::string where = "trial of 'P01', block 1, position 1, attempt 1: ";
    expect_refused([](Trial &trial) { trial.response = Chosen{0}; }, where + "alternatives are");
    expect_refused([&](Trial &trial) { trial.response = Adjusted{kNaN}; }, "level adjusted is not");
    expect_refused([&](Trial &trial) { trial.tuning = {{"dR_Ohm", kNaN}}; }, "'dR_Ohm' is not");
    expect_refused(
        [](Trial &trial) {
            trial.tuning = {{"dR", 1.0}, {"dR", 2.0}};
        },
        "'dR' is there twice");
    expect_refused(
        [](Trial &trial) {
            trial.presentations = {{0.0, 1.0, {{"a,b", {}, {}}}}};
        },
        "'a,b' is no name");
    expect_refused([](Trial &trial) { trial.marks = {""}; }, "a mark has no reason");
    expect_refused(
        [](Trial &trial) {
            trial.marks.clear();
            trial.is_presented_again = true;
        },
        "nothing says why");
    for (const char *const path : {"/etc/passwd", "a.rec", "direction.records/P02/a.rec",
                                   "direction.records/P01/../P02/a.rec", "direction.records/P01",
                                   "direction.records/P01/", "other/P01/a.rec", ""}) {
        expect_refused(
            [&](Trial &trial) {
                trial.record = {path, std::string(64, 'a')};
            },
            std::string(path) + "' is not in the participant's folder of records");
    }
    expect_refused(
        [](Trial &trial) {
            trial.record = {"direction.records/P01/a.rec", "a"};
        },
        "SHA-256 is not one");
    EXPECT_TRUE(store.contents().trials.empty());
    // And what is no error: the same trial without a change.
    EXPECT_EQ(store.append(sample_trial(1, 1, 1)), Appended::now);
}

TEST(StudyStore, RepeatsATrialOnce) {
    const auto file = sample_study(fresh_folder("study_repeats"));
    StudyStore store(file);
    store.append(sample_trial(1, 1, 1));
    Trial repetition = sample_trial(1, 1, 2);
    repetition.repetition_of = TrialPlace{1, 1, 1};
    store.append(repetition);
    const auto trials = store.contents().trials;
    EXPECT_EQ(trials[0].repeated_by, repetition.place);
    EXPECT_EQ(trials[1].repeated_by, std::nullopt);
    Trial again = sample_trial(1, 1, 3);
    again.repetition_of = TrialPlace{1, 1, 1};
    EXPECT_EQ(error_text_of([&] { store.append(again); }),
              file.string() + ": has a repetition already of block 1, position 1, attempt 1");
    EXPECT_EQ(store.contents().trials.size(), 2U);
}

TEST(StudyStore, LinksServoRecords) {
    const auto folder = fresh_folder("study_records");
    const auto file = sample_study(folder);
    StudyStore store(file);
    const auto record = store.new_record_file("P01", {2, 17, 1});
    EXPECT_EQ(record, folder / "direction.records/P01/block2-position017-attempt1.rec");
    EXPECT_NE(error_text_of([&] { static_cast<void>(store.new_record_file("P09", {})); }), "");
    std::ofstream(record) << "abc";
    Trial trial = sample_trial(1, 1, 1);
    trial.record = store.link_to(record);
    EXPECT_EQ(trial.record->path, "direction.records/P01/block2-position017-attempt1.rec");
    // FIPS 180-2, appendix B.1: SHA-256 of "abc"
    EXPECT_EQ(trial.record->sha256,
              "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(store.append(trial), Appended::now);
    const auto problems = [&] { return validate_records(file, read_study(file)); };
    EXPECT_EQ(problems(), std::vector<std::string>{});
    const std::string where =
        trial.record->path.string() + ": record of P01, block 1, position 1, attempt 1: ";
    std::ofstream(record) << "abd";
    EXPECT_EQ(problems(), std::vector{where + "is another file than the one that was linked"});
    std::filesystem::remove(record);
    EXPECT_EQ(problems(), std::vector{where + "is missing"});
    EXPECT_NE(error_text_of([&] { static_cast<void>(store.link_to(record)); }), "");
    EXPECT_EQ(error_text_of([&] { static_cast<void>(store.link_to(file)); }),
              file.string() + ": is not in the study's folder of records, direction.records");
}

TEST(UtcTime, IsTextToTheMillisecond) {
    // date -u -d @1717155296 gives Fri May 31 11:34:56 AM UTC 2024
    EXPECT_EQ(utc_text(kStart), "2024-05-31T11:34:56.789Z");
    EXPECT_EQ(utc_text(UtcTime{}), "1970-01-01T00:00:00.000Z");
    EXPECT_EQ(utc_time_of("2024-05-31T11:34:56.789Z"), kStart);
    for (const char *const text :
         {"", "2024-05-31", "2024-05-31T11:34:56Z", "2024-02-30T11:34:56.789Z",
          "2024-05-31T24:00:00.000Z", "2024-05-31T11:60:00.000Z", "2024-05-31T11:34:60.000Z",
          "2024-05-31 11:34:56.789Z", "2024-05-31T11:34:56.7890", "+024-05-31T11:34:56.789Z"}) {
        EXPECT_EQ(utc_time_of(text), std::nullopt) << text;
    }
    const UtcTime now = utc_now();
    EXPECT_EQ(utc_time_of(utc_text(now)), now);
}

/// Reading and opening for writing say one line, which has `part`; nothing else is touched.
void expect_refused(const ForgedStudy &study, const std::string &part, const std::string &what) {
    for (const std::string &said : {said_on_reading(study.file()), said_on_opening(study.file())}) {
        EXPECT_NE(said.find(part), std::string::npos) << what << ": " << said;
        EXPECT_TRUE(
            std::ranges::none_of(said, [](char c) { return static_cast<unsigned char>(c) < 0x20; }))
            << what << ": " << said;
    }
    EXPECT_TRUE(study.is_rest_untouched()) << what;
}

TEST(HostileStudy, LeadsToNoFolderOfRecordsButItsOwn) {
    const std::string absolute =
        std::filesystem::absolute(testing::fresh_folder("hostile_absolute")).string();
    for (const std::string &name :
         {".."s, "."s, ""s, "/"s, absolute, "../beside"s, "in"s, "P01"s, "../beside.records"s,
          "a/../../beside.records"s, absolute + "/x.records", "x\n.records"s, "x\0.records"s,
          std::string(300, 'x') + ".records"}) {
        const ForgedStudy study("hostile_folder", testing::sample_new_study());
        study.forge_records_folder(name);
        study.forge_record((std::filesystem::path(name) / "P01/a.rec").string());
        study.forge_removal();
        expect_refused(study, ": is damaged (", name);
        EXPECT_NE(error_text_of([&] { StudyStore(study.file()).remove_participant("P01"); }), "");
        EXPECT_TRUE(study.is_rest_untouched()) << name;
    }
}

TEST(HostileStudy, HasNoParticipantsButCodes) {
    for (const std::string &code : {"../P01"s, ".."s, "."s, ""s, "P01/.."s, "P01\0"s, "P01\n"s,
                                    "/tmp"s, "../../beside/P01"s, std::string(300, 'P') + "1"}) {
        const ForgedStudy study("hostile_code", testing::sample_new_study());
        study.forge_code(code);
        expect_refused(study, ": is damaged (", code);
    }
}

TEST(HostileStudy, LinksNoRecordsButThoseOfItsTrials) {
    for (const std::string &path :
         {"/etc/passwd"s, "../beside/P01/kept"s, "h.records/P01/../../P01/kept"s,
          "h.records/P02/a.rec"s, "h.records/P01/a\0.rec"s, "h.records/P01/a\nb"s,
          "h.records/P01/" + std::string(300, 'x')}) {
        const ForgedStudy study("hostile_record", testing::sample_new_study());
        study.forge_record(path);
        expect_refused(study, ": is damaged (", path);
    }
}

/// What a link leads to is not even read.
TEST(HostileStudy, ReadsNoRecordsByWayOfALink) {
    const ForgedStudy study("hostile_link", testing::sample_new_study());
    const std::filesystem::path record = study.records() / "P01/block1-position001-attempt1.rec";
    const auto problems = [&] { return validate_records(study.file(), read_study(study.file())); };
    ASSERT_TRUE(std::filesystem::exists(record));
    EXPECT_EQ(problems(), std::vector<std::string>{});
    std::filesystem::remove(record);
    std::filesystem::create_symlink(study.canary(), record);
    ASSERT_EQ(problems().size(), 1U);
    EXPECT_NE(problems().front().find("is a link"), std::string::npos) << problems().front();
}

/// Only who requests a deletion gets one, whatever the study says of itself.
TEST(HostileStudy, RemovesNothingUnrequested) {
    const ForgedStudy study("hostile_removal", testing::sample_new_study());
    study.forge_removal();
    study.forge_records_folder("other.records");
    study.forge_record("other.records/P01/kept");
    {
        StudyStore store(study.file());
        store.append(Note{testing::kStart, "note", "the room is warm", {}, {}});
        EXPECT_EQ(store.contents().unfinished_removals, std::vector<std::string>{"P01"});
        EXPECT_TRUE(store.contents().trials.empty());
    }
    EXPECT_EQ(read_study(study.file()).unfinished_removals, std::vector<std::string>{"P01"});
    EXPECT_TRUE(study.is_rest_untouched());
}

/// SQLite deletes the file that a journal names, even for a reader.
TEST(HostileStudy, HasAJournalThatNamesAnotherFile) {
    const ForgedStudy study("hostile_journal", testing::sample_new_study());
    study.forge_journal(study.canary());
    expect_refused(study, "h.study-journal: names another file", "journal");
}

/// The lock is written to, and so are journals.
TEST(HostileStudy, HasALinkForALockOrJournal) {
    using Link = std::function<void(const std::filesystem::path &, const std::filesystem::path &)>;
    const Link symbolic = [](const auto &to, const auto &name) {
        std::filesystem::create_symlink(to, name);
    };
    const Link hard = [](const auto &to, const auto &name) {
        std::filesystem::create_hard_link(to, name);
    };
    for (const Link &link : {symbolic, hard}) {
        for (const char *const ending : {"-lock", "-journal", "-wal", "-shm"}) {
            const ForgedStudy study("hostile_beside", testing::sample_new_study());
            const std::string name = study.file().string() + ending;
            link(study.canary(), name);
            EXPECT_EQ(said_on_opening(study.file()).find(name + ": is a link or no ordinary"), 0U);
            static_cast<void>(said_on_reading(study.file())); // which needs no lock
            EXPECT_TRUE(study.is_rest_untouched()) << name;
        }
    }
    // Nor is a lock made through a link to nothing.
    const ForgedStudy study("hostile_new", testing::sample_new_study());
    symbolic("../beside/new", study.file().string() + "-lock");
    EXPECT_NE(said_on_opening(study.file()), "");
    EXPECT_TRUE(study.is_rest_untouched());
}

TEST(StudyModes, AreTheOwnersAloneUnderEachUmask) {
    for (const mode_t mask : {0000U, 0022U, 0077U}) {
        const testing::Umask umask(mask);
        const ForgedStudy study("study_modes", testing::sample_new_study());
        StudyStore store(study.file());
        EXPECT_EQ(mode_of(study.file()), 0600U);
        EXPECT_EQ(mode_of(study.file().string() + "-lock"), 0600U);
        EXPECT_EQ(mode_of(study.records()), 0700U);
        EXPECT_EQ(mode_of(study.records() / "P01"), 0700U);
        store.append(Note{testing::kStart, "note", "a", {}, {}});
        const Database database(study.file(), study.file(), Access::write, {});
        Transaction transaction(database, Transaction::Kind::write);
        database.run("UPDATE note SET text = 'b'");
        database.run("PRAGMA cache_spill = 1");
        EXPECT_EQ(mode_of(study.file().string() + "-journal"), 0600U);
    }
}

/// Somebody may have shared it on purpose.
TEST(StudyModes, OfAStudyThatIsThereStay) {
    const testing::Umask umask(0022);
    const ForgedStudy study("study_modes_kept", testing::sample_new_study());
    std::filesystem::permissions(study.file(), std::filesystem::perms(0640));
    std::filesystem::permissions(study.records(), std::filesystem::perms(0750));
    StudyStore store(study.file());
    store.append(Note{testing::kStart, "note", "a", {}, {}});
    store.add({"P02", 2, testing::kStart});
    static_cast<void>(store.new_record_file("P02", {}));
    EXPECT_EQ(mode_of(study.file()), 0640U);
    EXPECT_EQ(mode_of(study.records()), 0750U);
    EXPECT_EQ(mode_of(study.records() / "P02"), 0700U) << "what is new";
}

TEST(StudyModes, NoStudyHasANameThatItsRecordsCouldNotHave) {
    const auto folder = testing::fresh_folder("study_names");
    for (const std::string &name : {"a\nb.study"s, std::string(250, 'a') + ".study"}) {
        EXPECT_NE(error_text_of([&] {
                      create_study(folder / name, testing::sample_new_study(), testing::kStart);
                  }),
                  "");
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder));
}

} // namespace
} // namespace springdrive::study

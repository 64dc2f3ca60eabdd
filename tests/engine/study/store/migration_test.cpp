// Covers engine/study/store/schema.cpp: files of every version so far, and of two that do not exist
// yet.
#include "engine/study/store/schema.h"

#include "engine/study/store/rows.h"
#include "engine/study/store/study_file.h"
#include "engine/study/store/study_store.h"
#include "tests/engine/study/store/sample_study.h"
#include "tests/support/complaint.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <vector>

namespace springdrive::study {
namespace {

using testing::complaint_of;
using testing::contents_of;
using testing::fresh_folder;
using testing::sample_study;
using testing::sample_trial;
using testing::sample_trials;

/// A table of visits, as a later version may have; then a column with a default.
std::vector<const char *> later_steps() {
    std::vector<const char *> steps(schema_steps().begin(), schema_steps().end());
    steps.push_back("CREATE TABLE visit (id INTEGER PRIMARY KEY, participant TEXT NOT NULL "
                    "REFERENCES participant (code) ON DELETE CASCADE, room TEXT NOT NULL, "
                    "floor ANY NOT NULL) STRICT");
    steps.push_back("ALTER TABLE session ADD COLUMN experimenter TEXT;"
                    "INSERT INTO visit (participant, room, floor) "
                    "SELECT code, 'laboratory', 2 FROM participant");
    return steps;
}

/// The file of version 1 in version_1.sql.
std::filesystem::path file_of_version_1(const std::filesystem::path &folder) {
    const auto file = folder / "v1.study";
    const Database database(file, file, Access::create, {});
    database.run(contents_of(std::filesystem::path(SPRINGDRIVE_ASSET_DIR).parent_path() /
                             "tests/engine/study/store/version_1.sql"));
    return file;
}

/// A file of the present version or a later one, with a participant and ten trials.
std::filesystem::path file_of_version(std::size_t version, const std::filesystem::path &folder) {
    const auto file = sample_study(folder);
    {
        StudyStore store(file);
        for (int number = 1; number <= 10; ++number) {
            store.append(sample_trial(1, 1, number));
        }
    }
    const Database database(file, file, Access::write, {});
    const auto steps = later_steps();
    migrate(database, Steps(steps).first(version));
    return file;
}

TEST(Migration, TakesAFileOfEachVersionToTheLast) {
    const auto steps = later_steps();
    ASSERT_EQ(steps.size(), schema_steps().size() + 2);
    for (std::size_t version = schema_steps().size(); version <= steps.size(); ++version) {
        const auto file =
            file_of_version(version, fresh_folder("migrate_" + std::to_string(version)));
        const std::string bytes = contents_of(file);
        // Reading migrates a copy in memory.
        EXPECT_TRUE(
            testing::are_identical(read_file(file, file, steps).trials, sample_trials(1, 1, 10)));
        EXPECT_EQ(contents_of(file), bytes);

        const Database database = open_to_write(file, file, {}, steps);
        EXPECT_EQ(version_of(database), std::ssize(steps));
        check_structure(database, steps);
        EXPECT_EQ(database.number("SELECT count(*) FROM visit"), 1);
        EXPECT_TRUE(
            testing::are_identical(read_contents(database).trials, sample_trials(1, 1, 10)));
    }
}

/// A file that the program of version 1 made; values are those of its SQL.
void expect_what_version_1_held(const StudyContents &contents) {
    EXPECT_EQ(contents.facts.title, "a study of version 1");
    EXPECT_EQ(contents.facts.software, "0.1.0");
    EXPECT_EQ(contents.facts.records_folder, "v1.records");
    ASSERT_EQ(contents.participants.size(), 2U);
    EXPECT_EQ(contents.participants[1].code, "P02");
    ASSERT_EQ(contents.sessions.size(), 2U);
    EXPECT_EQ(utc_text(contents.sessions[0].started), "2026-11-26T04:59:18.685Z");
    EXPECT_EQ(contents.sessions[1].ending, SessionEnding::completed);
    EXPECT_EQ(contents.sessions[1].facts.size(), 8U);
    EXPECT_EQ(contents.sessions[0].facts[1], (Setting{"observer_slope", 3.5}));
    ASSERT_EQ(contents.trials.size(), 14U);
    EXPECT_EQ(contents.trials[0].seed, 3185090318772920569U);
    EXPECT_EQ(contents.trials[0].level_name, "eta_added");
    EXPECT_EQ(contents.trials[0].response, Response(Chosen{1}));
    EXPECT_EQ(contents.trials[0].response_time_s, 0.61459644309508520976);
    EXPECT_EQ(contents.trials[1].response_time_s, 0.58199661392478041488);
    ASSERT_EQ(contents.notes.size(), 2U);
    EXPECT_EQ(contents.notes[0].text, "the room is warm");
    EXPECT_EQ(contents.notes[1].participant, "P02");
    EXPECT_TRUE(contents.answers.empty()) << "which version 1 had not";
}

TEST(Migration, TakesAFileThatVersion1Made) {
    const auto file = file_of_version_1(fresh_folder("migrate_version_1"));
    const std::string bytes = contents_of(file);
    const StudyContents before = read_study(file);
    expect_what_version_1_held(before);
    EXPECT_EQ(contents_of(file), bytes) << "reading it changes nothing";
    {
        StudyStore store(file);
        EXPECT_EQ(store.contents(), before);
        EXPECT_EQ(store.add({"P02", 2, "hand", "Which hand?", "left", testing::kStart}),
                  Appended::now);
    }
    expect_what_version_1_held([&] {
        StudyContents without = read_study(file);
        EXPECT_EQ(without.answers.size(), 1U);
        without.answers.clear();
        return without;
    }());
    const Database database(file, file, Access::read, {});
    EXPECT_EQ(version_of(database), 2);
    check_structure(database, schema_steps());
}

/// The other side: what is not as version 1 made it is refused, not migrated.
TEST(Migration, OfADamagedFileIsRefused) {
    for (const char *const damage :
         {"UPDATE trial SET target = 2 WHERE id = 1", "CREATE TABLE answer (id INTEGER) STRICT"}) {
        const auto file = file_of_version_1(fresh_folder("migrate_damaged"));
        Database(file, file, Access::write, {}).run(damage);
        EXPECT_NE(testing::said_on_reading(file), "") << damage;
        EXPECT_NE(testing::said_on_opening(file), "") << damage;
    }
}

TEST(Migration, OfNewerVersionsIsRefused) {
    const auto steps = later_steps();
    const auto present = static_cast<std::size_t>(std::ssize(schema_steps()));
    const auto file = file_of_version(present + 1, fresh_folder("migrate_newer"));
    const std::string bytes = contents_of(file);
    const std::string refusal =
        file.string() + ": is a study of version 3, and this program knows versions up to 2; open "
                        "it with a newer springdrive";
    EXPECT_EQ(complaint_of([&] { static_cast<void>(read_study(file)); }), refusal);
    EXPECT_EQ(complaint_of([&] { StudyStore store(file); }), refusal);
    EXPECT_EQ(contents_of(file), bytes);
    EXPECT_EQ(complaint_of([&] { static_cast<void>(read_file(file, file, steps)); }), "");
}

TEST(Migration, ThatFailsChangesNothing) {
    auto steps = later_steps();
    steps.back() = "CREATE TABLE other (id INTEGER) STRICT; INSERT INTO nowhere VALUES (1)";
    const auto file = file_of_version(schema_steps().size(), fresh_folder("migrate_fails"));
    EXPECT_EQ(complaint_of([&] { static_cast<void>(open_to_write(file, file, {}, steps)); }),
              file.string() + ": no such table: nowhere");
    const Database database(file, file, Access::write, {});
    EXPECT_EQ(version_of(database), 3); // the steps before are complete
    EXPECT_EQ(database.number("SELECT count(*) FROM sqlite_schema WHERE name = 'other'"), 0);
    steps.pop_back();
    check_structure(database, steps);
    EXPECT_EQ(read_contents(database).trials.size(), 10U);
}

} // namespace
} // namespace springdrive::study

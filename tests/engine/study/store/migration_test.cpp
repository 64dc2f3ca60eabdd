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

/// A table for questionnaires, as a later version may have; then a column with a default.
std::vector<const char *> later_steps() {
    std::vector<const char *> steps(schema_steps().begin(), schema_steps().end());
    steps.push_back("CREATE TABLE answer (id INTEGER PRIMARY KEY, participant TEXT NOT NULL "
                    "REFERENCES participant (code) ON DELETE CASCADE, question TEXT NOT NULL, "
                    "answer ANY NOT NULL) STRICT");
    steps.push_back("ALTER TABLE session ADD COLUMN experimenter TEXT;"
                    "INSERT INTO answer (participant, question, answer) "
                    "SELECT code, 'handedness', 'right' FROM participant");
    return steps;
}

/// A file of a version, with a participant and ten trials.
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
    for (std::size_t version = 1; version <= steps.size(); ++version) {
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
        EXPECT_EQ(database.number("SELECT count(*) FROM answer"),
                  version == steps.size() || version < steps.size() ? 1 : 0);
        EXPECT_TRUE(
            testing::are_identical(read_contents(database).trials, sample_trials(1, 1, 10)));
    }
}

TEST(Migration, OfNewerVersionsIsRefused) {
    const auto steps = later_steps();
    const auto present = static_cast<std::size_t>(std::ssize(schema_steps()));
    const auto file = file_of_version(present + 1, fresh_folder("migrate_newer"));
    const std::string bytes = contents_of(file);
    const std::string refusal =
        file.string() + ": is a study of version 2, and this program knows versions up to 1; open "
                        "it with a newer springdrive";
    EXPECT_EQ(complaint_of([&] { static_cast<void>(read_study(file)); }), refusal);
    EXPECT_EQ(complaint_of([&] { StudyStore store(file); }), refusal);
    EXPECT_EQ(contents_of(file), bytes);
    EXPECT_EQ(complaint_of([&] { static_cast<void>(read_file(file, file, steps)); }), "");
}

TEST(Migration, ThatFailsChangesNothing) {
    auto steps = later_steps();
    steps.back() = "CREATE TABLE other (id INTEGER) STRICT; INSERT INTO nowhere VALUES (1)";
    const auto file = file_of_version(1, fresh_folder("migrate_fails"));
    EXPECT_EQ(complaint_of([&] { static_cast<void>(open_to_write(file, file, {}, steps)); }),
              file.string() + ": no such table: nowhere");
    const Database database(file, file, Access::write, {});
    EXPECT_EQ(version_of(database), 2); // the steps before are complete
    EXPECT_EQ(database.number("SELECT count(*) FROM sqlite_schema WHERE name = 'other'"), 0);
    steps.pop_back();
    check_structure(database, steps);
    EXPECT_EQ(read_contents(database).trials.size(), 10U);
}

} // namespace
} // namespace springdrive::study

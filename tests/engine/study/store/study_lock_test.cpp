// Covers engine/study/store/study_lock.cpp: one writer, any number of readers.
#include "engine/study/store/study_store.h"

#include "tests/engine/study/store/sample_study.h"
#include "tests/support/child_process.h"
#include "tests/support/error_text.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <optional>

namespace springdrive::study {
namespace {

using testing::error_text_of;
using testing::fresh_folder;
using testing::said_in_child;
using testing::said_on_opening;
using testing::sample_study;
using testing::sample_trial;

std::string holder(const std::filesystem::path &file, pid_t process) {
    return file.string() + ": is open for writing already, by process " + std::to_string(process) +
           " on ";
}

TEST(StudyLock, RefusesASecondWriterAtOnceNamingTheFirst) {
    const auto folder = fresh_folder("lock_second");
    const auto file = sample_study(folder);
    std::optional<StudyStore> store(file);
    const auto begun = std::chrono::steady_clock::now();
    const std::string here = said_on_opening(file);
    const std::string elsewhere = said_in_child([] {}, [&] { return said_on_opening(file); });
    // The first trial that waits for a lock of SQLite would take ten seconds.
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(5));
    EXPECT_TRUE(here.starts_with(holder(file, getpid()))) << here;
    EXPECT_TRUE(here.ends_with("; end that one first")) << here;
    EXPECT_EQ(elsewhere, here);
    EXPECT_EQ(here.find('\n'), std::string::npos);

    // By another name, too.
    std::filesystem::create_symlink(file, folder / "link");
    EXPECT_TRUE(said_on_opening(folder / "link").starts_with(holder(folder / "link", getpid())));

    EXPECT_EQ(store->append(sample_trial(1, 1, 1)), Appended::now);
    store.reset();
    EXPECT_FALSE(std::filesystem::exists(file.string() + "-lock"));
    EXPECT_EQ(said_on_opening(file), "");
    EXPECT_EQ(said_in_child([] {}, [&] { return said_on_opening(file); }), "");
    EXPECT_EQ(read_study(file).trials.size(), 1U);
}

TEST(StudyLock, DoesNotHinderReaders) {
    const auto file = sample_study(fresh_folder("lock_reader"));
    StudyStore store(file);
    for (int number = 1; number <= 3; ++number) {
        store.append(sample_trial(1, 1, number));
        EXPECT_EQ(read_study(file).trials.size(), static_cast<std::size_t>(number));
        const auto count = [&] { return std::to_string(read_study(file).trials.size()); };
        EXPECT_EQ(said_in_child([] {}, count), std::to_string(number));
        // Reading and closing in this process took no lock away.
        EXPECT_NE(said_in_child([] {}, [&] { return said_on_opening(file); }), "");
    }
}

TEST(StudyLock, EndsWithItsProcess) {
    const auto file = sample_study(fresh_folder("lock_killed"));
    std::array<int, 2> ends{};
    ASSERT_EQ(pipe(ends.data()), 0);
    const pid_t child = fork();
    if (child == 0) {
        const StudyStore store(file);
        [[maybe_unused]] const ssize_t sent = write(ends[1], "x", 1);
        pause();
        _exit(0);
    }
    char opened = ' ';
    ASSERT_EQ(read(ends[0], &opened, 1), 1);
    EXPECT_TRUE(said_on_opening(file).starts_with(holder(file, child)));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    EXPECT_TRUE(std::filesystem::exists(file.string() + "-lock"));
    EXPECT_EQ(said_on_opening(file), "");
    close(ends[0]);
    close(ends[1]);
}

} // namespace
} // namespace springdrive::study

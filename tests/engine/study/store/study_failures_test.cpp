// Covers engine/study/store/ as a whole: a running study whose program is killed, whose machine
// loses power, or whose disk is full, at a call of SQLite to the system that a seed chooses.
#include "engine/study/store/study_store.h"

#include "engine/study/store/database.h"
#include "tests/engine/study/store/failing_disk.h"
#include "tests/engine/study/store/sample_study.h"
#include "tests/support/cases.h"
#include "tests/support/error_text.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <atomic>
#include <csignal>
#include <functional>
#include <new>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

namespace springdrive::study {
namespace {

using testing::are_identical;
using testing::DiskFailure;
using testing::error_text_of;
using testing::fresh_folder;
using testing::sample_study;
using testing::sample_trial;
using testing::sample_trials;

constexpr int kTrialsOfStudy = 12;

/// A study that runs from its first trial to its last, in a folder of its own.
class RunningStudy : public ::testing::Test {
protected:
    RunningStudy() { testing::install_failing_disk(); }

    /// A new study, and the call at which it will fail.
    std::uint64_t begin(DiskFailure failure, std::uint64_t seed_of_case) {
        seed = seed_of_case;
        const auto renew = [&](DiskFailure planned, std::uint64_t at_call) {
            std::filesystem::copy_file(fresh, file,
                                       std::filesystem::copy_options::overwrite_existing);
            testing::plan_failure(folder, planned, at_call);
        };
        renew(DiskFailure::none, 0);
        run([](int) {});
        const std::uint64_t calls = testing::calls_of_disk(); // of an undisturbed study
        const std::uint64_t at_call = split_mix::value(seed, 0) % calls;
        renew(failure, at_call);
        return at_call;
    }

    /// Opens the study and stores its trials; calls `stored` after each. @return the error that
    /// ended it, empty at the end
    std::string run(const std::function<void(int)> &stored) {
        return error_text_of([&] {
            StudyStore store(file, settings);
            for (int number = 1; number <= kTrialsOfStudy; ++number) {
                store.append(sample_trial(seed, 1, number));
                stored(number);
            }
        });
    }

    /// Whether the file is sound, and holds the trials up to `acknowledged` and at most the next.
    bool holds_all(int acknowledged) {
        std::vector<Trial> trials;
        if (!error_text_of([&] { trials = read_study(file).trials; }).empty()) {
            return false;
        }
        return are_identical(trials, sample_trials(seed, 1, acknowledged)) ||
               are_identical(trials, sample_trials(seed, 1, acknowledged + 1));
    }

    /// Goes on after the last trial that was acknowledged, on a sound disk; then the study is as if
    /// nothing had happened.
    void expect_resumed(int acknowledged) {
        testing::plan_failure(folder, DiskFailure::none);
        StudyStore store(file, settings);
        for (int number = acknowledged + 1; number <= kTrialsOfStudy; ++number) {
            store.append(sample_trial(seed, 1, number));
        }
        EXPECT_TRUE(are_identical(store.contents().trials, sample_trials(seed, 1, kTrialsOfStudy)));
    }

    /// Of so many losses of power, how many lost a trial, or the study.
    int losses(int cases) {
        int lost = 0;
        for (int i = 0; i < cases; ++i) {
            int acknowledged = 0;
            begin(DiskFailure::power_loss, static_cast<std::uint64_t>(i));
            run([&](int number) { acknowledged = number; });
            testing::lose_power(seed);
            lost += holds_all(acknowledged) ? 0 : 1;
        }
        return lost;
    }

    std::filesystem::path folder = fresh_folder("running_study");
    std::filesystem::path fresh = sample_study(fresh_folder("running_study_fresh"));
    std::filesystem::path file = folder / fresh.filename();
    DatabaseSettings settings{.vfs = testing::kFailingDisk};
    std::uint64_t seed = 0;

    using Acknowledged = std::atomic<int>;
    static_assert(Acknowledged::is_always_lock_free);
};

using StudyFailures = RunningStudy;

TEST_F(StudyFailures, OfPowerLoseNoTrial) {
    const int cases = testing::cases(24, 400);
    int with_next = 0;
    for (int i = 0; i < cases; ++i) {
        int acknowledged = 0;
        const std::uint64_t at_call = begin(DiskFailure::power_loss, static_cast<std::uint64_t>(i));
        const std::string said = run([&](int number) { acknowledged = number; });
        EXPECT_TRUE(testing::has_failed());
        EXPECT_NE(said, "") << "at call " << at_call;
        EXPECT_EQ(said.find('\n'), std::string::npos);
        testing::lose_power(seed);
        ASSERT_TRUE(holds_all(acknowledged))
            << "seed " << seed << ", call " << at_call << ", " << testing::said_on_reading(file);
        with_next += std::ssize(read_study(file).trials) > acknowledged ? 1 : 0;
        expect_resumed(acknowledged);
    }
    std::printf("counts of %d losses of power: 0 trials lost, %d times one more than was "
                "acknowledged\n",
                cases, with_next);
}

/// The other side: settings that are faster lose trials, and this proof sees it.
TEST_F(StudyFailures, OfPowerLoseTrialsWithOtherSettings) {
    const int cases = testing::cases(24, 400);
    settings.synchronous = "FULL"; // the journal's deletion is not synced
    const int full = losses(cases);
    settings.synchronous = "NORMAL";
    const int normal = losses(cases);
    settings.synchronous = "OFF";
    const int off = losses(cases);
    settings.journal_mode = "MEMORY";
    const int in_memory = losses(cases);
    std::printf("counts of %d losses of power: trials lost %d times with synchronous FULL, %d with "
                "NORMAL, %d with OFF, %d with OFF and the journal in memory\n",
                cases, full, normal, off, in_memory);
    EXPECT_GT(full, 0);
    EXPECT_GT(normal, 0);
    EXPECT_GT(off, cases / 4);
    EXPECT_GT(in_memory, cases / 4);
}

TEST_F(StudyFailures, OfTheProgramLoseNoTrial) {
    const int cases = testing::cases(24, 300);
    void *const memory = mmap(nullptr, sizeof(Acknowledged), PROT_READ | PROT_WRITE,
                              MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    Acknowledged &acknowledged = *new (memory) Acknowledged(0);
    for (int i = 0; i < cases; ++i) {
        const std::uint64_t at_call = begin(DiskFailure::kill, static_cast<std::uint64_t>(i));
        acknowledged = 0;
        const pid_t child = fork();
        if (child == 0) {
            run([&](int number) { acknowledged = number; });
            _exit(0);
        }
        int status = 0;
        waitpid(child, &status, 0);
        EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << at_call;
        ASSERT_TRUE(holds_all(acknowledged))
            << "seed " << seed << ", call " << at_call << ", " << testing::said_on_reading(file);
        expect_resumed(acknowledged);
    }
    munmap(memory, sizeof(Acknowledged));
    std::printf("counts of %d kills: 0 trials lost\n", cases);
}

TEST_F(StudyFailures, OfAFullDiskLoseNoTrial) {
    const int cases = testing::cases(24, 300);
    int while_open = 0;
    for (int i = 0; i < cases; ++i) {
        const std::uint64_t at_call = begin(DiskFailure::full, static_cast<std::uint64_t>(i));
        StudyStore store(file, settings);
        for (int number = 1; number <= kTrialsOfStudy; ++number) {
            const auto append = [&] { store.append(sample_trial(seed, 1, number)); };
            std::string said = error_text_of(append);
            if (said.empty()) {
                continue;
            }
            ++while_open;
            // The disk is full for as long as somebody needs to notice.
            for (int again = 0; again < 3; ++again) {
                EXPECT_EQ(said, file.string() + ": the disk is full: nothing of this was stored, "
                                                "all before it is; free disk space and repeat it")
                    << at_call;
                EXPECT_TRUE(
                    are_identical(read_study(file).trials, sample_trials(seed, 1, number - 1)));
                said = error_text_of(append);
            }
            testing::free_space();
            EXPECT_EQ(error_text_of(append), "");
        }
        ASSERT_TRUE(are_identical(read_study(file).trials, sample_trials(seed, 1, kTrialsOfStudy)))
            << "seed " << seed << ", call " << at_call;
    }
    std::printf("counts of %d full disks: 0 trials lost, %d noticed\n", cases, while_open);
    EXPECT_GT(while_open, cases / 2); // the rest is at a sync or a deletion, which need no space
}

} // namespace
} // namespace springdrive::study

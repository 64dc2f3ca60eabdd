// Covers engine/study/store/ as a whole: a running study whose program is killed, whose machine
// loses power, or whose disk is full, at a call of SQLite to the system that a seed chooses; and
// the deletion of a participant, after which no byte is left of what the study knew of them.
#include "base/input_error.h"
#include "engine/study/store/database.h"
#include "engine/study/store/study_store.h"
#include "tests/engine/study/store/failing_disk.h"
#include "tests/engine/study/store/sample_study.h"
#include "tests/support/cases.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <atomic>
#include <csignal>
#include <fstream>
#include <functional>
#include <new>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

namespace springdrive::study {
namespace {

using testing::are_identical;
using testing::contents_of;
using testing::DiskFailure;
using testing::fresh_folder;
using testing::kStart;
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

constexpr int kTrialsOfEach = 10;
constexpr TrialPlace kMarkedPlace{1, 1, 1};
constexpr const char *kMarker = "left-handed violinist";

/// A study with the participants P01 and P02, and servo records of both.
class Removal : public ::testing::Test {
protected:
    Removal() {
        testing::install_failing_disk();
        StudyStore store(file);
        for (int participant = 1; participant <= 2; ++participant) {
            for (int number = 1; number <= kTrialsOfEach; ++number) {
                Trial trial = sample_trial(1, participant, number);
                if (participant == 2) {
                    trial.condition = kMarker;
                    trial.tuning = {{"hand", std::string(kMarker)}};
                }
                if (participant == 1 && trial.place == kMarkedPlace) {
                    trial.marks.emplace_back("P02 came in");
                }
                store.append(trial);
            }
            const auto record = store.new_record_file(participant == 1 ? "P01" : "P02", {});
            std::ofstream(record) << kMarker;
        }
        Session session = sample_session_of_marker();
        const SessionId begun = store.begin(session);
        store.add({"P02", begun, "remarks", "Anything else?", kMarker, kStart});
        store.end(begun, SessionEnding::left, kStart);
        store.add({"P01", 1, "remarks", "Anything else?", "no", kStart});
        store.append({kStart, "note", kMarker, "P02", std::nullopt});
        store.append({kStart, "note", "the room is warm", std::nullopt, std::nullopt});
        // What others' rows and those of the study say of them.
        store.append(
            {kStart, "note", "P02 came late, p02's pen broke", std::nullopt, std::nullopt});
        store.append({kStart, "note", "swapped with P02", "P01", std::nullopt});
        store.add({"P01", 1, "who", "Who told you of it?", "P02.", kStart});
    }

    static Session sample_session_of_marker() {
        Session session = testing::sample_session(2);
        session.facts.push_back({"hand", std::string(kMarker)});
        return session;
    }

    /// Files of the study, and of P02's records, that contain `bytes`.
    [[nodiscard]] int files_with(const std::string &bytes) const {
        int count = 0;
        for (const auto &entry : std::filesystem::recursive_directory_iterator(folder)) {
            const bool is_in_name = entry.path().filename().string().find(bytes) != bytes.npos;
            const bool is_others = entry.path().parent_path().filename() == "P01";
            const bool is_inside = entry.is_regular_file() && !is_others &&
                                   contents_of(entry.path()).find(bytes) != bytes.npos;
            count += is_in_name || is_inside ? 1 : 0;
        }
        return count;
    }

    static std::vector<Trial> trials_of_the_other(const std::string &mark) {
        std::vector<Trial> trials = sample_trials(1, 1, kTrialsOfEach);
        trials.front().marks.push_back(mark);
        return trials;
    }

    void expect_only_the_other_is_left() const {
        for (const char *const bytes : {kMarker, "P02", "p02"}) {
            EXPECT_EQ(files_with(bytes), 0) << bytes;
        }
        const StudyContents left = read_study(file);
        EXPECT_TRUE(are_identical(left.trials, trials_of_the_other("[removed] came in")));
        EXPECT_EQ(left.participants.size(), 1U);
        EXPECT_EQ(left.sessions.size(), 1U);
        ASSERT_EQ(left.answers.size(), 2U);
        EXPECT_EQ(left.answers[0].answer, "no");
        EXPECT_EQ(left.answers[1].answer, "[removed].");
        ASSERT_EQ(left.notes.size(), 3U);
        EXPECT_EQ(left.notes[0].text, "the room is warm");
        EXPECT_EQ(left.notes[1].text, "[removed] came late, [removed]'s pen broke");
        EXPECT_EQ(left.notes[2].text, "swapped with [removed]");
        EXPECT_EQ(left.facts.removed_participants, 1);
        EXPECT_EQ(contents_of(folder / "direction.records/P01/block1-position001-attempt1.rec"),
                  kMarker);
    }

    std::filesystem::path folder = fresh_folder("removal");
    std::filesystem::path file = sample_study(folder, 2);
};

TEST_F(Removal, LeavesNoByte) {
    EXPECT_EQ(files_with(kMarker), 2);
    EXPECT_EQ(files_with("P02"), 2); // the file, and the folder of records
    {
        StudyStore store(file);
        EXPECT_NE(error_text_of([&] { store.remove_participant("P03"); }), "");
        const Removed removed = store.remove_participant("P02");
        EXPECT_EQ(removed.redacted, 4); // two notes, an answer, a mark
        EXPECT_FALSE(removed.is_in_study);
        expect_only_the_other_is_left();
        EXPECT_EQ(error_text_of([&] {
                      store.remove_participant("P02");
                  }).find(file.string() + ": has no participant 'P02'"),
                  0U);
        // Code and number can be given anew.
        store.add({"P02", 2, kStart});
        EXPECT_EQ(store.contents().facts.removed_participants, 1);
        EXPECT_EQ(store.contents().trials.size(), static_cast<std::size_t>(kTrialsOfEach));
    }
}

/// The other side: rows that are merely deleted are still in the file.
TEST_F(Removal, OfRowsAloneLeavesTheirBytes) {
    {
        const Database database(file, file, Access::write, {});
        database.run("PRAGMA secure_delete = OFF; DELETE FROM participant WHERE code = 'P02'");
    }
    std::filesystem::remove_all(folder / "direction.records/P02");
    EXPECT_EQ(read_study(file).participants.size(), 1U);
    EXPECT_EQ(files_with(kMarker), 1);
    EXPECT_EQ(files_with("P02"), 1);
}

TEST_F(Removal, ThatCannotRemoveARecordGoesOnWhenItIsRequestedAgain) {
    const auto stuck = folder / "direction.records/P02/stuck";
    std::filesystem::create_directory(stuck);
    std::ofstream(stuck / "a.rec") << kMarker;
    for (const auto &entry : std::filesystem::recursive_directory_iterator(folder)) {
        std::filesystem::permissions(entry.path(), std::filesystem::perms(0777));
    }
    std::filesystem::permissions(folder, std::filesystem::perms(0777));
    std::filesystem::permissions(folder.parent_path(), std::filesystem::perms(0755));
    std::filesystem::permissions(stuck, std::filesystem::perms(0555));
    const auto in_child = [&](const std::function<void()> &step) {
        return testing::said_in_child(testing::drop_rights, [&] { return error_text_of(step); });
    };
    const std::string refusal = (folder / "direction.records/P02").string() +
                                ": cannot be removed: Permission denied; make it writable and "
                                "repeat";
    EXPECT_EQ(in_child([&] { StudyStore(file).remove_participant("P02"); }), refusal);
    EXPECT_EQ(read_study(file).participants.size(), 1U); // not seen any more
    EXPECT_TRUE(are_identical(read_study(file).trials, trials_of_the_other("P02 came in")));
    EXPECT_EQ(in_child([&] { StudyStore(file).remove_participant("P02"); }), refusal);
    std::filesystem::permissions(stuck, std::filesystem::perms(0777));
    EXPECT_EQ(in_child([&] { StudyStore store(file); }), "");
    EXPECT_EQ(contents_of(stuck / "a.rec"), kMarker) << "opening a study removes nothing";
    EXPECT_EQ(read_study(file).unfinished_removals, std::vector<std::string>{"P02"});
    EXPECT_EQ(in_child([&] { StudyStore(file).remove_participant("P02"); }), "");
    expect_only_the_other_is_left();
}

/// Its protocol is what its sessions go by.
TEST_F(Removal, SaysThatTheStudyItselfNamesTheCode) {
    EXPECT_FALSE(StudyStore(file).remove_participant("P01").is_in_study);
    const auto named = fresh_folder("removal_named") / "P01.study";
    create_study(named, {"Direction", "", "1.0"}, kStart);
    StudyStore store(named);
    store.add({"P01", 1, kStart});
    EXPECT_TRUE(store.remove_participant("P01").is_in_study);
}

TEST_F(Removal, DoesNotFollowLinksOutOfTheFolder) {
    const auto outside = fresh_folder("removal_outside");
    std::ofstream(outside / "kept") << "kept";
    std::filesystem::create_directory_symlink(outside, folder / "direction.records/P02/link");
    StudyStore(file).remove_participant("P02");
    expect_only_the_other_is_left();
    EXPECT_EQ(contents_of(outside / "kept"), "kept");
}

/// A folder that is reached by a link belongs to somebody else.
TEST_F(Removal, IsNotBegunWhereRecordsAreReachedByALink) {
    const auto outside = fresh_folder("removal_linked");
    std::filesystem::create_directory(outside / "P02");
    std::ofstream(outside / "P02/kept") << "kept";
    const auto records = folder / "direction.records";
    std::filesystem::rename(records, folder / "away");
    for (const std::filesystem::path &target :
         {outside, std::filesystem::path("."), std::filesystem::path("away")}) {
        std::filesystem::create_directory_symlink(target, records);
        EXPECT_EQ(error_text_of([&] {
                      StudyStore(file).remove_participant("P02");
                  }).find(records.string() + ": is a link"),
                  0U);
        EXPECT_EQ(read_study(file).participants.size(), 2U);
        EXPECT_NE(
            error_text_of([&] { static_cast<void>(StudyStore(file).new_record_file("P02", {})); }),
            "");
        std::filesystem::remove(records);
    }
    EXPECT_EQ(contents_of(outside / "P02/kept"), "kept");
    EXPECT_TRUE(std::filesystem::exists(folder / "away/P02"));
    std::filesystem::rename(folder / "away", records);
    StudyStore(file).remove_participant("P02");
    expect_only_the_other_is_left();
}

/// Deletions that end with the program or the power.
class RemovalStudyFailures : public Removal {
protected:
    void try_all(DiskFailure failure, int cases) {
        const auto whole = fresh_folder("removal_whole");
        copy(folder, whole);
        const DatabaseSettings settings{.vfs = testing::kFailingDisk};
        const auto remove_it = [&] {
            return error_text_of([&] { StudyStore(file, settings).remove_participant("P02"); });
        };
        testing::plan_failure(folder, DiskFailure::none);
        EXPECT_EQ(remove_it(), "");
        const std::uint64_t calls = testing::calls_of_disk();
        int begun = 0;
        int requested = 0;
        for (int i = 0; i < cases; ++i) {
            copy(whole, folder);
            // Every second time in the first calls, which mark the participant; most of the others
            // rebuild the file.
            const std::uint64_t at_call = split_mix::value(7, static_cast<std::uint64_t>(i)) %
                                          (i % 2 == 0 ? std::min<std::uint64_t>(calls, 16) : calls);
            testing::plan_failure(folder, failure, at_call);
            if (failure == DiskFailure::kill) {
                const pid_t child = fork();
                if (child == 0) {
                    remove_it();
                    _exit(0);
                }
                int status = 0;
                waitpid(child, &status, 0);
                EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << at_call;
            } else {
                EXPECT_NE(remove_it(), "") << at_call;
                testing::lose_power(static_cast<std::uint64_t>(i));
            }
            const StudyContents left = read_study(file);
            if (left.participants.size() == 2) { // as before, records too
                EXPECT_EQ(left.trials.size(), 2U * kTrialsOfEach) << at_call;
                EXPECT_TRUE(std::filesystem::exists(folder / "direction.records/P02"));
                StudyStore(file).remove_participant("P02");
            } else {
                ++begun;
                const bool has_records = std::filesystem::exists(folder / "direction.records/P02");
                StudyStore store(file); // rebuilds the file, if that is all that is left
                EXPECT_EQ(std::filesystem::exists(folder / "direction.records/P02"), has_records);
                EXPECT_EQ(store.contents().unfinished_removals, left.unfinished_removals);
                for (const std::string &code : left.unfinished_removals) {
                    ++requested;
                    store.remove_participant(code);
                }
            }
            expect_only_the_other_is_left();
        }
        std::printf("counts of %d deletions that ended early: %d were completed when they were "
                    "requested again, %d at the next opening, %d had not begun\n",
                    cases, requested, begun - requested, cases - begun);
        EXPECT_GT(requested, 0);
        EXPECT_LT(begun, cases);
    }

    static void copy(const std::filesystem::path &from, const std::filesystem::path &to) {
        std::filesystem::remove_all(to);
        std::filesystem::copy(from, to, std::filesystem::copy_options::recursive);
    }
};

TEST_F(RemovalStudyFailures, OfTheProgramAreMadeGood) {
    try_all(DiskFailure::kill, testing::cases(16, 150));
}

TEST_F(RemovalStudyFailures, OfPowerAreMadeGood) {
    try_all(DiskFailure::power_loss, testing::cases(16, 150));
}

} // namespace
} // namespace springdrive::study

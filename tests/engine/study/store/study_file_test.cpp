// Covers engine/study/store/{study_file,database}.cpp: files that are no studies, or
// damaged; one writer, any number of readers.
#include "base/input_error.h"
#include "base/parallel.h"
#include "base/sha256.h"
#include "engine/study/store/rows.h"
#include "engine/study/store/study_file.h"
#include "engine/study/store/study_store.h"
#include "tests/engine/study/store/sample_study.h"
#include "tests/support/cases.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <fstream>
#include <functional>
#include <optional>
#include <sys/wait.h>
#include <unistd.h>

namespace springdrive::study {
namespace {

using testing::are_identical;
using testing::contents_of;
using testing::fresh_folder;
using testing::said_in_child;
using testing::said_on_opening;
using testing::said_on_reading;
using testing::sample_study;
using testing::sample_trial;
using testing::sample_trials;

void put(const std::filesystem::path &file, const std::string &bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
}

/// Refused alike for reading and writing, in one line that begins so; and not a byte is changed.
void expect_refused(const std::filesystem::path &file, const std::string &why) {
    const std::string bytes = contents_of(file);
    for (const std::string &said : {said_on_reading(file), said_on_opening(file)}) {
        EXPECT_EQ(said.find(file.string() + ": " + why), 0U) << said;
    }
    EXPECT_EQ(contents_of(file), bytes);
    EXPECT_FALSE(std::filesystem::exists(file.string() + "-journal"));
    EXPECT_FALSE(std::filesystem::exists(file.string() + "-lock"));
}

TEST(StudyFile, ThatIsNoneIsRefused) {
    const auto folder = fresh_folder("file_none");
    expect_refused(folder / "missing", "does not exist");
    EXPECT_EQ(said_on_reading(folder), folder.string() + ": is a folder; name a study file");
    put(folder / "text", "[study]\ntitle = \"direction\"\n" + std::string(2000, '#'));
    expect_refused(folder / "text", "is no study: it is not an SQLite database");
    put(folder / "empty", "");
    expect_refused(folder / "empty", "is empty, no study");
    Database(folder / "other", folder / "other", Access::create, {})
        .run("CREATE TABLE trial (id INTEGER)");
    expect_refused(folder / "other", "is no study of springdrive");
    Database(folder / "other", folder / "other", Access::write, {})
        .run("PRAGMA application_id = 1196444487; PRAGMA user_version = 1"); // GeoPackage
    expect_refused(folder / "other", "is no study of springdrive");
}

TEST(StudyFile, ThatIsDeletedMeanwhileIsMissed) {
    const auto folder = fresh_folder("file_deleted");
    const auto file = sample_study(folder);
    const auto kept = folder / "kept";
    StudyStore store(file);
    store.append(sample_trial(1, 1, 1));
    std::filesystem::rename(file, kept);
    const auto append = [&] { store.append(sample_trial(1, 1, 2)); };
    EXPECT_EQ(error_text_of(append).find(file.string() + ": was moved or deleted"), 0U);
    std::filesystem::rename(kept, file);
    EXPECT_EQ(error_text_of(append), "");
    EXPECT_TRUE(are_identical(read_study(file).trials, sample_trials(1, 1, 2)));
}

TEST(StudyFile, IsCreatedByOneOfManyAtOnce) {
    const auto file = fresh_folder("file_creators") / "a.study";
    constexpr std::size_t kCreators = 8;
    std::array<std::string, kCreators> said;
    in_chunks(kCreators, kCreators, [&](unsigned creator, std::size_t, std::size_t) {
        said[creator] = error_text_of([&] {
            create_study(file, {std::to_string(creator), "", "1.0"}, testing::kStart);
        });
    });
    const std::string refusal =
        file.string() + ": exists already; a study is never replaced: give another name";
    EXPECT_EQ(std::ranges::count(said, std::string()), 1);
    EXPECT_EQ(std::ranges::count(said, refusal), kCreators - 1);
    const auto first = std::ranges::find(said, std::string()) - said.begin();
    EXPECT_EQ(read_study(file).facts.title, std::to_string(first)) << "and keeps what it wrote";
}

/// A study with trials, closed.
std::filesystem::path study_with_trials(const std::filesystem::path &folder, int trials) {
    const auto file = sample_study(folder, 2);
    StudyStore store(file);
    for (int number = 1; number <= trials; ++number) {
        store.append(sample_trial(1, 1, number));
    }
    return file;
}

TEST(StudyFile, ThatAnotherProgramChangedIsRefused) {
    const auto file = study_with_trials(fresh_folder("file_changed"), 3);
    const auto change = [&](const std::string &sql) {
        Database(file, file, Access::write, {}).run(sql);
    };
    change("UPDATE trial SET level = 7.0 WHERE id = 2");
    expect_refused(file, "is damaged (row 2 of table trial has changed)");
    change("DELETE FROM trial");
    EXPECT_EQ(said_on_reading(file), "");
    change("ALTER TABLE note ADD COLUMN colour TEXT");
    expect_refused(file, "is damaged (its tables are not as springdrive made them)");
}

TEST(StudyFile, OfAnotherVersionIsRefused) {
    const auto file = study_with_trials(fresh_folder("file_version"), 3);
    const auto expect_refused_as = [&](int version, const std::string &made_by) {
        Database(file, file, Access::write, {})
            .run("PRAGMA user_version = " + std::to_string(version));
        expect_refused(file, "is a study of version " + std::to_string(version) +
                                 ", and this program knows version 2 only; open it with " +
                                 made_by + " springdrive");
    };
    expect_refused_as(1, "an older");
    expect_refused_as(3, "a newer");
    Database(file, file, Access::write, {}).run("PRAGMA user_version = 2");
    EXPECT_EQ(said_on_opening(file), "");
}

/// By which studies that were made before open: not to be changed without the version.
TEST(StudyFile, OfVersion2HasItsTablesAndSums) {
    const auto file = study_with_trials(fresh_folder("file_format"), 12);
    {
        StudyStore store(file);
        store.append({testing::kStart, "note", "the room is warm", "P01", 1});
        store.add({"P01", 1, "hand", "Which hand?", "left", testing::kStart});
    }
    const Database database(file, file, Access::read, {});
    const auto sum_of = [&](const std::string &selection) {
        const std::string text =
            database.text("SELECT group_concat(line, char(10)) FROM (" + selection + ")");
        Sha256 sha256;
        sha256.add(text.data(), text.size());
        return sha256.hex();
    };
    EXPECT_EQ(sum_of("SELECT sql AS line FROM sqlite_schema WHERE sql <> '' ORDER BY name"),
              "85c7db1757505ff92cbbd7c5758d66bb2486d8c70894c297bb05247232ab2d54");
    std::string rows;
    for (const char *const table : {"study", "participant", "session", "trial", "answer", "note"}) {
        rows +=
            std::string(rows.empty() ? "" : " UNION ALL ") + "SELECT sha256 AS line FROM " + table;
    }
    EXPECT_EQ(sum_of(rows), "539b23a2026b02c01749ca0becc2cf0c4b92de1d3faebc40fde90cc1e109715f");
}

TEST(StudyFile, ThatIsCutIsRefused) {
    const auto file = study_with_trials(fresh_folder("file_cut"), 10);
    const StudyContents contents = read_study(file);
    const std::string bytes = contents_of(file);
    for (std::size_t length : {std::size_t{1}, std::size_t{15}, std::size_t{16}, std::size_t{99},
                               std::size_t{100}, std::size_t{512}, std::size_t{4096},
                               bytes.size() / 2, bytes.size() - 4096, bytes.size() - 1}) {
        put(file, bytes.substr(0, length));
        const std::string said = said_on_reading(file);
        if (said.empty()) { // the last bytes of a page can be unused
            EXPECT_EQ(length, bytes.size() - 1);
            EXPECT_EQ(read_study(file), contents);
        }
        EXPECT_EQ(said_on_opening(file), said) << length;
        EXPECT_EQ(said.find('\n'), std::string::npos);
    }
    put(file, bytes);
    EXPECT_EQ(said_on_opening(file), "");
}

/// Changes bytes, or puts random ones in their place.
std::string mutated(std::string bytes, std::uint64_t seed) {
    testing::Draws draws(seed);
    if (draws.below(40) == 0) { // noise after a good beginning
        bytes.resize(draws.below(bytes.size()));
        for (std::size_t i = bytes.size() + draws.below(std::size_t{3000}); bytes.size() < i;) {
            bytes.push_back(static_cast<char>(draws.below(256)));
        }
        return bytes;
    }
    const std::size_t page =
        draws.below(2) == 0 ? 4096 : bytes.size(); // the first page rules the others
    for (std::size_t i = 1 + draws.below(std::size_t{4}); i > 0; --i) {
        const std::size_t at = draws.below(page);
        switch (draws.below(3)) {
        case 0:
            bytes[at] = static_cast<char>(bytes[at] ^ (1 << draws.below(8)));
            break;
        case 1:
            bytes[at] = static_cast<char>(draws.below(256));
            break;
        default: { // a sector that was not written, or that is another one's
            const std::size_t sector = at / 512 * 512;
            bytes.replace(sector, 512,
                          draws.below(2) == 0
                              ? std::string(512, '\0')
                              : bytes.substr(draws.below(bytes.size() / 512) * 512, 512));
        }
        }
    }
    return bytes;
}

TEST(DamagedStudies, AreReadWholeOrRefused) {
    const auto folder = fresh_folder("file_fuzz");
    const auto original = study_with_trials(folder, 12);
    const StudyContents contents = read_study(original);
    const std::string bytes = contents_of(original);
    int whole = 0;
    int refused = 0;
    const int cases = testing::cases(300, 20'000);
    for (int i = 0; i < cases; ++i) {
        const auto file = folder / "damaged.study";
        std::filesystem::remove(file); // to write over a file would wait for the disk
        put(file, mutated(bytes, static_cast<std::uint64_t>(i)));
        const auto expect_one_line = [&](const std::string &said) {
            EXPECT_TRUE(said.starts_with(file.string() + ": ")) << i << said;
            EXPECT_EQ(said.find('\n'), std::string::npos) << i << said;
        };
        try {
            const StudyContents read = read_study(file);
            EXPECT_EQ(read, contents) << i;
            EXPECT_TRUE(testing::are_identical(read.trials, contents.trials)) << i;
            ++whole;
        } catch (const InputError &error) {
            expect_one_line(error.what());
            ++refused;
        }
        // Opening for writing may also repair what reading cannot see: never the contents.
        try {
            EXPECT_EQ(StudyStore(file).contents(), contents) << i;
        } catch (const InputError &error) {
            expect_one_line(error.what());
        }
        std::filesystem::remove(file.string() + "-journal");
        std::filesystem::remove(file.string() + "-wal");
        std::filesystem::remove(file.string() + "-shm");
    }
    std::printf("counts of %d damaged files: %d read whole, %d refused\n", cases, whole, refused);
    EXPECT_GT(whole, cases / 5); // much of a page is unused
    EXPECT_GT(refused, cases / 5);
}

TEST(StudyFile, IsReadFromAWriteProtectedFolder) {
    const auto folder = fresh_folder("file_protected");
    const auto file = study_with_trials(folder, 3);
    const auto protect = [&](int mode) {
        std::filesystem::permissions(file, std::filesystem::perms(mode & 0666));
        std::filesystem::permissions(folder, std::filesystem::perms(mode));
        std::filesystem::permissions(folder.parent_path(), std::filesystem::perms(0755));
    };
    const auto in_child = [&](const std::function<std::string()> &step) {
        return said_in_child(testing::drop_rights, step);
    };
    protect(0555);
    EXPECT_EQ(in_child([&] { return std::to_string(read_study(file).trials.size()); }), "3");
    const auto expect_said = [&](const std::function<std::string()> &step, const char *part) {
        const std::string said = in_child(step);
        EXPECT_NE(said.find(part), std::string::npos) << said;
    };
    const auto open = [&] { return said_on_opening(file); };
    expect_said(open, ": cannot be locked for writing: Permission denied");
    expect_said(
        [&] {
            return error_text_of([&] {
                create_study(folder / "b.study", testing::sample_new_study(), testing::kStart);
            });
        },
        "b.study: cannot be written: Permission denied");
    // The file alone.
    std::filesystem::permissions(folder, std::filesystem::perms(0777));
    expect_said(open, ": is write-protected, or its folder is");
    std::filesystem::permissions(file, std::filesystem::perms(0));
    expect_said([&] { return said_on_reading(file); }, ": cannot be opened: Permission denied");
    protect(0777);
    EXPECT_EQ(said_on_opening(file), "");
}

TEST(StudyFile, InTheMidstOfAWriteIsRepairedWhereItCanBe) {
    const auto folder = fresh_folder("file_hot");
    const auto file = study_with_trials(folder, 5);
    const std::string before = contents_of(file);
    const pid_t child = fork();
    if (child == 0) { // killed after it wrote to the file and before it committed
        const Database database(file, file, Access::write, {});
        database.run("PRAGMA cache_size = 2; BEGIN; DELETE FROM trial; SELECT 1");
        database.run("PRAGMA cache_spill = ON; UPDATE participant SET number = number + 10");
        std::raise(SIGKILL);
    }
    waitpid(child, nullptr, 0);
    const std::string torn = contents_of(file);
    const std::string journal = contents_of(file.string() + "-journal");
    ASSERT_NE(torn, before);
    ASSERT_FALSE(journal.empty());
    std::filesystem::permissions(folder, std::filesystem::perms(0555));
    std::filesystem::permissions(file, std::filesystem::perms(0444));
    const std::string said =
        said_in_child(testing::drop_rights, [&] { return said_on_reading(file); });
    EXPECT_EQ(said.find(file.string() + ": was left in the midst of a write"), 0U) << said;
    std::filesystem::permissions(folder, std::filesystem::perms(0777));
    std::filesystem::permissions(file, std::filesystem::perms(0666));
    EXPECT_EQ(read_study(file).trials.size(), 5U);
    EXPECT_EQ(contents_of(file), before);
    EXPECT_FALSE(std::filesystem::exists(file.string() + "-journal"));
}

TEST(StudyFile, OnAFullDiskKeepsWhatItHas) {
    const auto file = study_with_trials(fresh_folder("file_full"), 3);
    StudyStore store(file);
    const std::string bytes = contents_of(file);
    Trial trial = sample_trial(1, 1, 4);
    trial.condition = std::string(20'000, 'x');
    {
        const testing::FullDisk full(bytes.size() + 4096);
        EXPECT_EQ(error_text_of([&] { store.append(trial); }),
                  file.string() +
                      ": the disk failed in writing; check it and its free space, and repeat");
    }
    EXPECT_EQ(contents_of(file), bytes);
    EXPECT_EQ(store.append(trial), Appended::now);
    EXPECT_EQ(read_study(file).trials.size(), 4U);
}

/// Beside a study stand files with longer names.
TEST(StudyFile, HasANameOfAnyLengthOrIsRefusedAndNotThere) {
    const auto folder = fresh_folder("file_lengths");
    constexpr std::size_t kMaxBytes = 255 - 8; // of "-journal"
    for (std::size_t bytes = 240; bytes <= 255; ++bytes) {
        const auto file = folder / (std::string(bytes - 6, 'x') + ".study");
        const std::string said = error_text_of(
            [&] { create_study(file, testing::sample_new_study(), testing::kStart); });
        if (bytes <= kMaxBytes) {
            EXPECT_EQ(said, "") << bytes;
            static_cast<void>(StudyStore(file).contents());
            std::filesystem::remove(file);
        } else {
            EXPECT_NE(said.find(" " + std::to_string(bytes - kMaxBytes) + " bytes too long"),
                      std::string::npos)
                << bytes << said;
        }
        EXPECT_TRUE(std::filesystem::is_empty(folder)) << bytes;
    }
}

TEST(StudyFile, IsNotCreatedOnAFullDisk) {
    const auto folder = fresh_folder("file_full_new");
    const auto file = folder / "a.study";
    const testing::FullDisk full(10'000);
    EXPECT_EQ(
        error_text_of([&] { create_study(file, testing::sample_new_study(), testing::kStart); }),
        file.string() + ": the disk failed in writing; check it and its free space, and repeat");
    EXPECT_TRUE(std::filesystem::is_empty(folder));
}

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

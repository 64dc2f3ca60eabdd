// Covers base/new_file.cpp.
#include "base/new_file.h"

#include "tests/support/error_text.h"
#include "tests/support/files.h"
#include "tests/support/modes.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>

namespace springdrive {
namespace {

using testing::contents_of;
using testing::error_text_of;

std::ptrdiff_t files_in(const std::filesystem::path &folder) {
    return std::distance(std::filesystem::directory_iterator(folder), {});
}

void write(const std::filesystem::path &file, const std::string &text) {
    std::ofstream(file) << text;
}

TEST(NewFile, AppearsWhenItIsPublished) {
    const std::filesystem::path folder = testing::fresh_folder("new_file");
    {
        NewFile file(folder / "a");
        write(file.temporary(), "new");
        EXPECT_FALSE(std::filesystem::exists(folder / "a"));
        file.publish(Existing::keep);
        EXPECT_EQ(contents_of(folder / "a"), "new");
    }
    EXPECT_EQ(files_in(folder), 1);
}

TEST(NewFile, LeavesNothingIfItIsNotPublished) {
    const std::filesystem::path folder = testing::fresh_folder("new_file_dropped");
    write(folder / "a", "old");
    {
        NewFile file(folder / "a");
        write(file.temporary(), "half");
    }
    EXPECT_EQ(contents_of(folder / "a"), "old");
    EXPECT_EQ(files_in(folder), 1);
}

TEST(NewFile, KeepsWhatAppearedMeanwhile) {
    const std::filesystem::path folder = testing::fresh_folder("new_file_kept");
    {
        NewFile file(folder / "a");
        write(file.temporary(), "new");
        write(folder / "a", "of another program");
        EXPECT_EQ(error_text_of([&] { file.publish(Existing::keep); }),
                  (folder / "a").string() + ": exists; use --force to replace it");
    }
    EXPECT_EQ(contents_of(folder / "a"), "of another program");
    EXPECT_EQ(files_in(folder), 1);
}

TEST(NewFile, ReplacesWhatALinkLeadsToWithItsPermissions) {
    const std::filesystem::path folder = testing::fresh_folder("new_file_link");
    write(folder / "a", "old");
    std::filesystem::permissions(folder / "a", std::filesystem::perms(0640));
    std::filesystem::create_symlink("a", folder / "link");
    std::filesystem::create_hard_link(folder / "a", folder / "hard");
    NewFile file(folder / "link");
    write(file.temporary(), "new");
    file.publish(Existing::replace);
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
    EXPECT_EQ(contents_of(folder / "a"), "new");
    EXPECT_EQ(std::filesystem::status(folder / "a").permissions(), std::filesystem::perms(0640));
    EXPECT_EQ(contents_of(folder / "hard"), "old"); // another name of the old file
}

TEST(NewFile, IsItsOwnersAloneWhereItIsPersonalWhateverTheUmask) {
    const std::filesystem::path folder = testing::fresh_folder("new_file_modes");
    struct Case {
        mode_t umask;
        unsigned for_all;
        unsigned for_owner;
    };
    for (const Case &one : {Case{0000, 0666, 0600}, Case{0022, 0644, 0600}, Case{0027, 0640, 0600},
                            Case{0077, 0600, 0600}}) {
        const testing::Umask umask(one.umask);
        for (const Readers readers : {Readers::all, Readers::owner}) {
            NewFile file(folder / "a", readers);
            const unsigned expected = readers == Readers::all ? one.for_all : one.for_owner;
            EXPECT_EQ(testing::mode_of(file.temporary()), expected);
            file.publish(Existing::keep);
            EXPECT_EQ(testing::mode_of(folder / "a"), expected);
            std::filesystem::remove(folder / "a");
        }
        EXPECT_EQ(make_folders_for_owner(folder / "b/c"), std::error_code());
        EXPECT_EQ(testing::mode_of(folder / "b/c"), 0700U & ~one.umask);
        EXPECT_EQ(testing::mode_of(folder / "b"), 0700U & ~one.umask);
        std::filesystem::remove_all(folder / "b");
    }
}

/// Nobody else reads what replaces a private file, at no time.
TEST(NewFile, IsNeverReadableByMoreThanTheFileThatItReplaces) {
    const std::filesystem::path folder = testing::fresh_folder("new_file_private");
    const testing::Umask umask(0);
    for (const unsigned mode : {0600U, 0640U, 0400U}) {
        write(folder / "a", "old");
        std::filesystem::permissions(folder / "a", std::filesystem::perms(mode));
        NewFile file(folder / "a");
        EXPECT_EQ(testing::mode_of(file.temporary()) & 0077U & ~mode, 0U);
        file.publish(Existing::replace);
        EXPECT_EQ(testing::mode_of(folder / "a"), mode);
        std::filesystem::remove(folder / "a");
    }
    EXPECT_EQ(others_access_text(folder / "none"), "");
    write(folder / "a", "");
    EXPECT_EQ(others_access_text(folder / "a"),
              (folder / "a").string() +
                  ": others have rights to it (mode 666); unless that is "
                  "meant: chmod go= " +
                  (folder / "a").string());
}

TEST(NewFile, HasATemporaryNameThatNobodyGuesses) {
    const std::filesystem::path folder = testing::fresh_folder("new_file_names");
    std::set<std::filesystem::path> names;
    for (int i = 0; i < 100; ++i) {
        const NewFile file(folder / "a");
        const std::string name = file.temporary().filename().string();
        EXPECT_EQ(name.size(), std::string(".springdrive_0123456789abcdef").size());
        names.insert(name);
    }
    EXPECT_EQ(names.size(), 100U);
}

TEST(NewFile, IsNoDevice) {
    EXPECT_EQ(error_text_of([] { NewFile("/dev/null"); }),
              "/dev/null: is not a regular file; give another name");
    EXPECT_NE(error_text_of([] { NewFile("/no/such/folder/a"); }), "");
}

TEST(ResolvedName, IsTheSameForAllSpellings) {
    const std::filesystem::path folder =
        std::filesystem::canonical(testing::fresh_folder("resolved_name"));
    std::filesystem::create_directory(folder / "in");
    std::filesystem::create_symlink(folder / "in", folder / "linked");
    std::filesystem::create_symlink("in/none", folder / "dangling");
    for (const char *spelled : {"in/none", "./in/../in/none", "in//none", "linked/none", "dangling",
                                "linked/../dangling"}) {
        EXPECT_EQ(resolved_name(folder / spelled), folder / "in" / "none") << spelled;
    }
    std::filesystem::create_symlink("loop", folder / "loop");
    EXPECT_NO_THROW(static_cast<void>(resolved_name(folder / "loop")));
    EXPECT_TRUE(resolved_name("/dev/stdout").string().starts_with("/proc/"));
}

} // namespace
} // namespace springdrive

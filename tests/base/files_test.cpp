// Covers base/input_file.cpp, base/new_file.cpp and base/sha256.cpp. Paths by which a scene leaves
// its folder are in gltf_file_test.cpp.
#include "base/input_file.h"

#include "base/input_error.h"
#include "base/new_file.h"
#include "base/sha256.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <ctime>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <string_view>
#include <sys/stat.h>

namespace springdrive {
namespace {

TEST(ContainedPath, NamesAreOfOneFile) {
    for (const std::string &name :
         {std::string("a"), std::string("..."), std::string(".a"), std::string("ä b.rec"),
          std::string("a'b\"c"), std::string(255, 'a')}) {
        EXPECT_EQ(validate_file_name(name), "") << name;
    }
    using namespace std::string_literals;
    for (const std::string &name :
         {""s, "."s, ".."s, "a/b"s, "/"s, "a/"s, "a\0b"s, "a\n"s, "\x7f"s, std::string(256, 'a')}) {
        EXPECT_NE(validate_file_name(name), "") << name;
    }
}

TEST(ContainedPath, FilesMayBeBelowTheFolderButNotOutside) {
    const auto top = std::filesystem::canonical(testing::fresh_folder("contained"));
    const auto folder = top / "in";
    std::filesystem::create_directories(folder / "deep");
    std::filesystem::create_symlink("deep", folder / "link");
    std::filesystem::create_symlink("..", folder / "up");
    const auto error = [&](const std::string &path) {
        return error_text_of([&] { static_cast<void>(contained_file(path, folder, "protocol")); });
    };
    EXPECT_EQ(contained_file("deep/../a.toml", folder, "protocol"), folder / "a.toml");
    EXPECT_EQ(contained_file("./link/a.toml", folder, "protocol"), folder / "deep/a.toml");
    EXPECT_EQ(error("../a.toml"), "lies outside the protocol's folder and is not read; put the "
                                  "file there");
    EXPECT_EQ(error("a\nb"), error("../a.toml"));
    EXPECT_EQ(error((folder / "a.toml").string()),
              "is not relative to the protocol's file and is not read; put the file into the "
              "protocol's folder");
    EXPECT_EQ(error("up/a.toml"), "lies outside the protocol's folder, by way of a link, and "
                                  "is not read; put the file there");
}

TEST(ContainedPath, NoLinkIsFollowedWhereNoneMayBe) {
    const auto folder = testing::fresh_folder("without_links");
    std::filesystem::create_directories(folder / "a/b");
    std::filesystem::create_symlink("b", folder / "a/link");
    EXPECT_EQ(path_without_links(folder, "a/b/c"), folder / "a/b/c");
    EXPECT_EQ(error_text_of([&] { static_cast<void>(path_without_links(folder, "a/link/c")); }),
              (folder / "a/link").string() +
                  ": is a link, which is not followed; put there what it leads to");
    for (const char *const path : {"a/../a", "..", "a/", "/a", "./a", "a/\n"}) {
        EXPECT_NE(error_text_of([&] { static_cast<void>(path_without_links(folder, path)); }), "")
            << path;
    }
}

TEST(FileNames, CountOnWhereOneIsTaken) {
    std::set<std::filesystem::path> taken;
    for (const char *expected : {"plots.csv", "plots-2.csv", "plots-3.csv"}) {
        const std::filesystem::path name = unused_name(
            "plots.csv", [&](const std::filesystem::path &some) { return taken.contains(some); });
        EXPECT_EQ(name, expected);
        taken.insert(name);
    }
}

TEST(FileNames, HaveTheirNumberBeforeTheEnding) {
    EXPECT_EQ(numbered_name("a/touch.rec", 1), "a/touch.rec");
    EXPECT_EQ(numbered_name("a/touch.rec", 2), "a/touch-2.rec");
    EXPECT_EQ(numbered_name("touch", 10), "touch-10");
    EXPECT_EQ(numbered_name("a.b/x.y.rec", 3), "a.b/x.y-3.rec");
}

TEST(FileNames, HoldTheLocalTime) {
    const std::time_t before = std::time(nullptr);
    const std::string name = dated_name("a stem");
    std::tm parts{};
    ASSERT_EQ(name.substr(0, 7), "a stem-");
    const char *const end = strptime(name.c_str() + 7, "%Y%m%d-%H%M%S", &parts);
    ASSERT_NE(end, nullptr);
    EXPECT_EQ(*end, '\0');
    parts.tm_isdst = -1;
    EXPECT_LE(std::difftime(std::mktime(&parts), before), 2.0);
    EXPECT_GE(std::difftime(std::mktime(&parts), before), 0.0);
}

TEST(InputFile, IsAnOrdinaryFileOfLimitedSize) {
    const std::filesystem::path folder = testing::fresh_folder("input_file");
    const std::filesystem::path file = folder / "a.toml";
    std::ofstream(file) << "12345";
    const auto error = [](const std::filesystem::path &name, std::uintmax_t max_bytes) {
        return error_text_of([&] { check_input_file(name, "a TOML file", max_bytes); });
    };
    EXPECT_EQ(error(file, 5), "");
    EXPECT_EQ(error(file, 4), file.string() + ": has 5 bytes, more than the 4 of a TOML file");
    EXPECT_EQ(error(folder, 5), folder.string() + ": is a folder; name a TOML file");
    EXPECT_EQ(error("/dev/zero", 5), "/dev/zero: is no ordinary file; name a TOML file");
    const std::filesystem::path pipe = folder / "pipe"; // opening it would wait for a writer
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_EQ(error(pipe, 5), pipe.string() + ": is no ordinary file; name a TOML file");
    std::filesystem::create_symlink(pipe, folder / "link");
    EXPECT_NE(error(folder / "link", 5), "");
    EXPECT_EQ(error(folder / "missing", 5), "");
}

using testing::contents_of;

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

// The examples of FIPS 180.
TEST(Sha256, MatchesTheStandardForFiles) {
    const auto folder = testing::fresh_folder("sha256");
    write(folder / "abc", "abc");
    write(folder / "empty", "");
    write(folder / "million", std::string(1'000'000, 'a'));
    EXPECT_EQ(sha256_of_file(folder / "abc"),
              "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(sha256_of_file(folder / "empty"),
              "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(sha256_of_file(folder / "million"),
              "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

std::string of_texts(std::string_view first, std::string_view second) {
    Sha256 sha256;
    sha256.add(first);
    sha256.add(second);
    return sha256.hex();
}

TEST(Sha256, ContinuesOverSeveralCalls) {
    Sha256 sha256;
    sha256.add("a", 1);
    sha256.add("bc", 2);
    EXPECT_EQ(sha256.hex(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Sha256, SeparatesTexts) { EXPECT_NE(of_texts("ab", "c"), of_texts("a", "bc")); }

TEST(Sha256, NamesAFileThatCannotBeRead) {
    const auto folder = testing::fresh_folder("sha256_none");
    for (const auto &file : {folder / "none", folder}) {
        const std::string said = error_text_of([&] { (void)sha256_of_file(file); });
        EXPECT_NE(said.find(file.string() + ": cannot be read"), std::string::npos) << said;
    }
}

} // namespace
} // namespace springdrive

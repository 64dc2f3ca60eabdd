// Covers base/input_file.cpp. Paths by which a scene leaves its folder are in
// gltf_uri_test.cpp.
#include "base/input_file.h"

#include "tests/support/error_text.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <fstream>

namespace springdrive {
namespace {

using testing::error_text_of;

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

} // namespace
} // namespace springdrive

// Covers base/input_file.cpp.
#include "base/input_file.h"

#include "tests/support/error_text.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sys/stat.h>

namespace springdrive {
namespace {

using testing::error_text_of;

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

} // namespace
} // namespace springdrive

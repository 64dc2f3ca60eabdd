// Covers engine/servo/record/file_hash.cpp.
#include "engine/servo/record/file_hash.h"

#include "tests/engine/servo/record/samples.h"

#include <gtest/gtest.h>

namespace springdrive {
namespace {

// The examples of FIPS 180.
TEST(FileHash, IsSha256) {
    const auto folder = testing::fresh_folder("file_hash");
    testing::write_file(folder / "abc", "abc");
    testing::write_file(folder / "empty", "");
    testing::write_file(folder / "million", std::string(1'000'000, 'a'));
    EXPECT_EQ(sha256_of_file(folder / "abc"),
              "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(sha256_of_file(folder / "empty"),
              "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(sha256_of_file(folder / "million"),
              "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(FileHash, NamesAFileThatCannotBeRead) {
    const auto folder = testing::fresh_folder("file_hash_none");
    for (const auto &file : {folder / "none", folder}) {
        const std::string said = testing::complaint_of([&] { (void)sha256_of_file(file); });
        EXPECT_NE(said.find(file.string() + ": cannot be read"), std::string::npos) << said;
    }
}

} // namespace
} // namespace springdrive

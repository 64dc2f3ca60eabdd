// Covers base/sha256.cpp.
#include "base/sha256.h"

#include "tests/engine/record/samples.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace springdrive {
namespace {

// The examples of FIPS 180.
TEST(Sha256, MatchesTheStandardForFiles) {
    const auto folder = testing::fresh_folder("sha256");
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
        const std::string said = testing::error_text_of([&] { (void)sha256_of_file(file); });
        EXPECT_NE(said.find(file.string() + ": cannot be read"), std::string::npos) << said;
    }
}

} // namespace
} // namespace springdrive

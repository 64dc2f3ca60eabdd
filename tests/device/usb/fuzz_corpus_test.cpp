// Replays inputs that the fuzzer found (tests/fuzz/run), for both ends of the wire protocol.
#include "tests/fuzz/usb_targets.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <ostream>

namespace springdrive::fuzz {

/// For GoogleTest.
inline void PrintTo(const UsbTarget &target, std::ostream *out) { *out << target.name; }

namespace {

namespace fs = std::filesystem;

std::vector<std::uint8_t> bytes_of(const fs::path &file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

class FuzzCorpus : public ::testing::TestWithParam<UsbTarget> {};

TEST_P(FuzzCorpus, BreaksNothing) {
    const fs::path folder = testing::assets().parent_path() / "tests/fuzz/corpus";
    int files = 0;
    for (const auto &entry : fs::directory_iterator(folder / GetParam().name)) {
        const std::vector<std::uint8_t> input = bytes_of(entry.path());
        EXPECT_NO_THROW(GetParam().take(input)) << entry.path();
        // Cut off, the decisions after the end are others.
        EXPECT_NO_THROW(GetParam().take(std::span(input).first(input.size() / 2))) << entry.path();
        ++files;
    }
    EXPECT_GE(files, 10);
}

INSTANTIATE_TEST_SUITE_P(Usb, FuzzCorpus, ::testing::ValuesIn(kUsbTargets),
                         [](const ::testing::TestParamInfo<UsbTarget> &target) {
                             std::string name(target.param.name);
                             std::ranges::replace(name, '-', '_');
                             return name;
                         });

} // namespace
} // namespace springdrive::fuzz

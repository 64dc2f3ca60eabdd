// Covers docs/study_privacy.md: limits are those of the device files, and tests that it names
// exist.
#include "engine/servo/safety_limits.h"

#include "tests/engine/study/protocol/plain_protocol.h"
#include "tests/support/files.h"

#include <fmt/core.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>
#include <string>

namespace springdrive::study {
namespace {

std::filesystem::path top() { return testing::assets().parent_path(); }

std::string page() { return testing::contents_of(top() / "docs/study_privacy.md"); }

TEST(PrivacyPage, HasTheLimitsOfTheDevices) {
    const std::string text = page();
    const servo::SafetyLimits first = servo::limits_of(testing::phantom_1_0());
    const servo::SafetyLimits second = servo::limits_of(testing::phantom_premium_1_5());
    for (const servo::SafetyLimit &limit : servo::kSafetyLimits) {
        const std::string row = fmt::format("| {} [{}] | {:.4g} | {:.4g} |", limit.what, limit.unit,
                                            first.*limit.value * limit.shown_per_si,
                                            second.*limit.value * limit.shown_per_si);
        EXPECT_NE(text.find(row), std::string::npos) << row;
    }
}

/// "Suite.Name" of all tests.
std::set<std::string> all_tests() {
    std::set<std::string> names;
    const std::regex test(R"(TEST(?:_F|_P)?\((\w+),\s*(\w+)\))");
    for (const auto &entry : std::filesystem::recursive_directory_iterator(top() / "tests")) {
        if (entry.path().extension() != ".cpp") {
            continue;
        }
        const std::string source = testing::contents_of(entry.path());
        for (std::sregex_iterator at(source.begin(), source.end(), test), end; at != end; ++at) {
            names.insert((*at)[1].str() + "." + (*at)[2].str());
        }
    }
    return names;
}

TEST(PrivacyPage, NamesTestsThatExist) {
    const std::string text = page();
    const std::set<std::string> tests = all_tests();
    const std::regex named(R"(`([A-Z]\w+\.[A-Z]\w+)`)");
    int count = 0;
    for (std::sregex_iterator at(text.begin(), text.end(), named), end; at != end; ++at) {
        EXPECT_TRUE(tests.contains((*at)[1].str())) << (*at)[1].str();
        ++count;
    }
    EXPECT_GT(count, 15);
    EXPECT_FALSE(tests.contains("PrivacyPage.NamesATestThatDoesNot"));
}

} // namespace
} // namespace springdrive::study

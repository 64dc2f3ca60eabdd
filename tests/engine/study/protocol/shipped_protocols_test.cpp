// Covers assets/protocols, docs/study_protocol.md, and docs/study_privacy.md: limits are those of
// the device files, and tests that it names exist.
#include "engine/servo/safety_limits.h"
#include "engine/study/protocol/protocol_check.h"
#include "engine/study/protocol/protocol_file.h"
#include "tests/engine/study/protocol/plain_protocol.h"
#include "tests/support/error_text.h"
#include "tests/support/files.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>

namespace springdrive::study {
namespace {

const std::set<std::string> kShipped{"blow", "can_you_feel_it", "direction", "hardness",
                                     "mass", "stiffness"};

class ShippedProtocol : public ::testing::TestWithParam<std::string> {};

TEST_P(ShippedProtocol, HasNoErrorsAndTakesUnderAnHour) {
    const std::filesystem::path file = testing::assets() / "protocols" / (GetParam() + ".toml");
    const Protocol protocol = read_protocol_file(file);
    const CheckedProtocol checked =
        check_protocol(protocol, {file.parent_path(), testing::assets()});
    for (const ProtocolFinding &finding : checked.findings) {
        EXPECT_EQ(finding.severity, Severity::note) << text_of(finding);
    }
    EXPECT_LE(checked.length.max_s, 3600.0);
    EXPECT_FALSE(checked.trials.empty());
    EXPECT_NE(testing::contents_of(file).find("docs/study_protocol.md"), std::string::npos);
    if (GetParam() == "can_you_feel_it") {           // of visitors: nobody is asked for anything
        EXPECT_GE(checked.length.min_s, 3.0 * 60.0); // or it would say too little
        EXPECT_LE(checked.length.max_s, 5.0 * 60.0); // with the instructions
        EXPECT_TRUE(protocol.questionnaire.empty());
        EXPECT_EQ(protocol.conditions.size(), 1U);
        EXPECT_EQ(protocol.variable.parameter, "turn_deg");
    }
}

INSTANTIATE_TEST_SUITE_P(, ShippedProtocol, ::testing::ValuesIn(kShipped),
                         [](const auto &protocol) { return protocol.param; });

TEST(ShippedProtocols, AreTheOnesThatAreTested) {
    std::set<std::string> names;
    for (const auto &entry : std::filesystem::directory_iterator(testing::assets() / "protocols")) {
        names.insert(entry.path().stem().string());
    }
    EXPECT_EQ(names, kShipped);
}

/// docs/study_protocol.md has the tables of the list in the code.
TEST(ProtocolManual, HasEveryKeyOfTheList) {
    const std::string page =
        testing::contents_of(testing::assets().parent_path() / "docs/study_protocol.md");
    std::ostringstream tables;
    write_protocol_keys(tables);
    EXPECT_NE(page.find(tables.str()), std::string::npos) << "the page should have these tables:\n"
                                                          << tables.str();
}

/// The keys that the reader knows beside a line, as it tells them of one that it does not know.
std::set<std::string> known_beside(const std::string &beside) {
    const std::string text = testing::with(testing::kPlainProtocol, beside, beside + "zzz = 1\n");
    const std::string line =
        testing::error_text_of([&text] { static_cast<void>(testing::protocol_of(text)); });
    const std::string before = "the known keys are ";
    const std::size_t at = line.find(before);
    EXPECT_NE(at, std::string::npos) << line;
    std::istringstream list(
        line.substr(at == std::string::npos ? line.size() : at + before.size()));
    std::set<std::string> keys;
    for (std::string key; std::getline(list, key, ',');) {
        keys.insert(key.substr(key.find_first_not_of(' ')));
    }
    return keys;
}

/// And the list in the code is what the reader reads: in every table the same keys.
TEST(ProtocolManual, ItsListIsWhatTheReaderKnows) {
    std::map<std::string, std::set<std::string>> listed;
    std::stringstream manual;
    write_protocol_keys(manual);
    std::string heading;
    for (std::string line; std::getline(manual, line);) {
        const std::size_t from = line.find('`');
        const std::string name = from == std::string::npos
                                     ? ""
                                     : line.substr(from + 1, line.find('`', from + 1) - from - 1);
        if (line.ends_with(':')) {
            heading = name.substr(0, name.find_last_not_of(']') + 1);
            heading.erase(0, heading.find_first_not_of('['));
        } else if (line.starts_with("| `")) {
            listed[heading].insert(name);
        }
    }
    for (const char *table : {"texts", "free_space", "common", "variable", "task", "practice",
                              "catch_trials", "responses", "timing", "breaks", "marking",
                              "windings", "stopping", "noise", "expected"}) {
        const std::string line = std::string("[") + table + "]\n";
        EXPECT_EQ(known_beside(line), listed[table]) << table;
    }
    EXPECT_EQ(known_beside("name = \"one\"\n"), listed["block"]);
    EXPECT_EQ(known_beside("name = \"tiring\"\n"), listed["questions"]);
    std::set<std::string> of_condition = listed["common"];
    of_condition.merge(listed["condition"]);
    EXPECT_EQ(known_beside("name = \"a\"\n"), of_condition);
    // Before all tables, where the tables themselves are keys too.
    const std::set<std::string> root = known_beside("seed = 7\n");
    for (const std::string &key : listed[""]) {
        EXPECT_TRUE(root.contains(key)) << key;
    }
    for (const std::string &key : root) {
        EXPECT_TRUE(listed[""].contains(key) || listed.contains(key) || key == "method") << key;
    }
}

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

// Covers assets/protocols and docs/study_protocol.md.
#include "engine/study/protocol/protocol_check.h"
#include "engine/study/protocol/protocol_fields.h"
#include "tests/engine/study/protocol/plain_protocol.h"
#include "tests/support/error_text.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>

namespace springdrive::study {
namespace {

class ShippedProtocol : public ::testing::TestWithParam<const char *> {};

TEST_P(ShippedProtocol, HasNoErrorsAndTakesUnderAnHour) {
    const std::filesystem::path file =
        testing::assets() / "protocols" / (std::string(GetParam()) + ".toml");
    const Protocol protocol = read_protocol_file(file);
    const CheckedProtocol checked =
        check_protocol(protocol, {file.parent_path(), testing::assets()});
    for (const ProtocolFinding &finding : checked.findings) {
        EXPECT_EQ(finding.severity, Severity::note) << text_of(finding);
    }
    EXPECT_LE(checked.length.max_s, 3600.0);
    EXPECT_FALSE(checked.trials.empty());
    EXPECT_NE(testing::contents_of(file).find("docs/study_protocol.md"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(, ShippedProtocol,
                         ::testing::Values("blow", "can_you_feel_it", "direction", "hardness",
                                           "mass", "stiffness"),
                         [](const auto &protocol) { return std::string(protocol.param); });

TEST(ShippedProtocols, AreTheOnesThatAreTested) {
    std::set<std::string> names;
    for (const auto &entry : std::filesystem::directory_iterator(testing::assets() / "protocols")) {
        names.insert(entry.path().stem().string());
    }
    EXPECT_EQ(names, (std::set<std::string>{"blow", "can_you_feel_it", "direction", "hardness",
                                            "mass", "stiffness"}));
}

/// With the instructions, and nobody is asked for anything.
TEST(ShippedProtocols, TheVisitorsOneTakesAtMostFiveMinutes) {
    const std::filesystem::path file = testing::assets() / "protocols" / "can_you_feel_it.toml";
    const Protocol protocol = read_protocol_file(file);
    const CheckedProtocol checked =
        check_protocol(protocol, {file.parent_path(), testing::assets()});
    EXPECT_GE(checked.length.min_s, 3.0 * 60.0); // or it would say too little
    EXPECT_LE(checked.length.max_s, 5.0 * 60.0);
    EXPECT_TRUE(protocol.questionnaire.empty());
    EXPECT_EQ(protocol.conditions.size(), 1U);
    EXPECT_EQ(protocol.variable.parameter, "turn_deg");
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

/// The keys that the reader knows of a table, as it tells them of one that it does not know.
std::set<std::string> known_keys(const std::string &text) {
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
        EXPECT_EQ(known_keys(testing::with(testing::kPlainProtocol, line, line + "zzz = 1\n")),
                  listed[table])
            << table;
    }
    EXPECT_EQ(known_keys(testing::with(testing::kPlainProtocol, "name = \"one\"",
                                       "name = \"one\"\nzzz = 1")),
              listed["block"]);
    EXPECT_EQ(known_keys(testing::with(testing::kPlainProtocol, "name = \"tiring\"",
                                       "name = \"tiring\"\nzzz = 1")),
              listed["questions"]);
    std::set<std::string> of_condition = listed["common"];
    of_condition.merge(listed["condition"]);
    EXPECT_EQ(
        known_keys(testing::with(testing::kPlainProtocol, "name = \"a\"", "name = \"a\"\nzzz = 1")),
        of_condition);
    // Before all tables, where the tables themselves are keys too.
    const std::set<std::string> root =
        known_keys(testing::with(testing::kPlainProtocol, "seed = 7", "seed = 7\nzzz = 1"));
    for (const std::string &key : listed[""]) {
        EXPECT_TRUE(root.contains(key)) << key;
    }
    for (const std::string &key : root) {
        EXPECT_TRUE(listed[""].contains(key) || listed.contains(key) || key == "method") << key;
    }
}

} // namespace
} // namespace springdrive::study

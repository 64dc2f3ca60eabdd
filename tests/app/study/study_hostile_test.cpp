// Covers what the study commands do with studies and protocols from people who mean harm, and who
// may read what they write.
#include "tests/app/study/study_program.h"
#include "tests/engine/study/store/forged_study.h"
#include "tests/support/modes.h"

#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;
using testing::ForgedStudy;
using testing::mode_of;
using testing::study;

ForgedStudy forged(const std::string &name) {
    return {name, {"forged", testing::shortened("stiffness"), "1.0"}};
}

/// Each command that takes a study.
std::vector<std::vector<std::string>> commands_on(const fs::path &file) {
    const fs::path out = file.parent_path() / "h.out";
    return {{"note", file, "the room is warm"},
            {"status", file},
            {"export", file, "--csv", "-", "--device", "emulated"},
            {"export", file, "--bids", out, "--device", "emulated"},
            {"analyse", file, "--device", "emulated"},
            {"resume", file},
            {"run", file, "--participant", "P05", "--observer", "simulated"},
            {"remove", file, "P01"},
            {"remove", file, "P01", "--yes"}};
}

TEST(StudyHostile, IsRefusedByEachCommandInALine) {
    using Forge = void (*)(const ForgedStudy &);
    for (const Forge forge :
         {Forge([](const ForgedStudy &one) { one.forge_records_folder(".."); }),
          Forge([](const ForgedStudy &one) { one.forge_code("../beside/P01"); }),
          Forge([](const ForgedStudy &one) { one.forge_record("../beside/P01/kept"); }),
          Forge([](const ForgedStudy &one) { one.forge_journal(one.canary()); })}) {
        const ForgedStudy one = forged("hostile_commands");
        one.forge_removal();
        forge(one);
        for (const std::vector<std::string> &command : commands_on(one.file())) {
            testing::expect_refused(study(command), "h.study");
            EXPECT_TRUE(one.is_rest_untouched()) << command.front();
        }
        EXPECT_TRUE(fs::exists(one.records() / "P01"));
    }
}

/// A deletion that seems to have been interrupted, of records that may be somebody else's.
TEST(StudyHostile, RemovesRecordsOnlyWhenThatIsTyped) {
    const ForgedStudy one = forged("hostile_removal_command");
    one.forge_removal();
    const std::string text = "h.study: the deletion of P01 was interrupted; springdrive study "
                             "remove " +
                             one.file().string() + " P01 --yes completes it";
    for (const std::vector<std::string> &command : commands_on(one.file())) {
        if (command.back() == "--yes") {
            continue;
        }
        const testing::Ending ending = study(command);
        EXPECT_NE(ending.error.find(text), std::string::npos)
            << command.front() << ": " << ending.error;
        const bool goes_on = command.front() == "note" || command.front() == "status";
        EXPECT_EQ(ending.exit_status == 0, goes_on) << command.front();
        EXPECT_TRUE(fs::exists(one.records() / "P01")) << command.front();
    }
    fs::rename(one.records(), one.file().parent_path() / "h.kept");
    fs::create_directory_symlink("../beside", one.records());
    testing::expect_refused(study({"remove", one.file(), "P01", "--yes"}), "is a link");
    EXPECT_TRUE(one.is_rest_untouched());
    fs::remove(one.records());
    fs::rename(one.file().parent_path() / "h.kept", one.records());
    EXPECT_EQ(study({"remove", one.file(), "P01", "--yes"}).exit_status, 0);
    EXPECT_FALSE(fs::exists(one.records() / "P01"));
    EXPECT_TRUE(one.is_rest_untouched());
    EXPECT_EQ(study({"status", one.file()}).error, "");
}

TEST(StudyHostile, ProtocolsReadNothingOutsideOfTheirFolder) {
    const fs::path folder = testing::fresh_folder("hostile_protocol");
    fs::create_directory(folder / "in");
    fs::copy_file(testing::assets() / "devices/phantom_1_0.toml", folder / "mine.toml");
    fs::create_symlink("../mine.toml", folder / "in/link.toml");
    for (const std::string &name :
         {std::string("../mine.toml"), fs::absolute(folder / "mine.toml").string(),
          std::string("link.toml")}) {
        std::ofstream(folder / "in/a.toml") << std::regex_replace(
            testing::shortened("stiffness"), std::regex(R"(\ndevice = "phantom_1_0")"),
            "\ndevice = \"" + name + "\"");
        testing::expect_refused(study({"run", folder / "in/a.toml", "--participant", "P01",
                                       "--observer", "simulated", "--felt", "once"}),
                                "a.toml");
        EXPECT_FALSE(fs::exists(folder / "in/a.study"));
        const testing::Ending checked = study({"check", folder / "in/a.toml", "--no-simulation"});
        EXPECT_NE(checked.exit_status, 0);
        EXPECT_NE((checked.out + checked.error).find("protocol's "), std::string::npos)
            << checked.out << checked.error;
    }
}

TEST(StudyExports, AreTheirOwnersAlone) {
    const testing::Umask umask(0022);
    const ForgedStudy one = forged("export_modes");
    const fs::path folder = one.file().parent_path();
    const auto exported = [&](const std::string &force) {
        std::vector<std::string> typed{"export",   one.file(), "--device",
                                       "emulated", "--csv",    folder / "a.csv"};
        if (!force.empty()) {
            typed.push_back(force);
        }
        return study(typed);
    };
    ASSERT_EQ(exported("").exit_status, 0);
    EXPECT_EQ(mode_of(folder / "a.csv"), 0600U);
    // One that is there may be shared on purpose.
    fs::permissions(folder / "a.csv", fs::perms(0644));
    const testing::Ending again = exported("--force");
    EXPECT_EQ(again.exit_status, 0);
    EXPECT_NE(again.error.find("a.csv: others have rights to it (mode 644)"), std::string::npos);
    EXPECT_EQ(mode_of(folder / "a.csv"), 0644U);
}

TEST(StudyExports, OfSharedStudiesSayThatTheyAreShared) {
    const ForgedStudy one = forged("shared_study");
    EXPECT_EQ(study({"note", one.file(), "the room is warm"}).error, "");
    fs::permissions(one.file(), fs::perms(0640));
    fs::permissions(one.records(), fs::perms(0755));
    const testing::Ending ending = study({"note", one.file(), "the room is warm"});
    EXPECT_EQ(ending.exit_status, 0);
    EXPECT_NE(ending.error.find("h.study: others have rights to it (mode 640)"), std::string::npos)
        << ending.error;
    EXPECT_NE(ending.error.find("h.records: others have rights to it (mode 755)"),
              std::string::npos)
        << ending.error;
    EXPECT_EQ(mode_of(one.file()), 0640U);
}

} // namespace
} // namespace springdrive::app

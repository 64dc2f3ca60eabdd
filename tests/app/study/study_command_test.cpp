// Covers app/commands/study/study_new.cpp, study_check.cpp and check_report.cpp, from outside.
#include "engine/study/store/study_store.h"
#include "tests/app/study/study_program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

using testing::study;

TEST(StudyCommand, ListsTheIncludedProtocols) {
    const testing::Ending told = study({"new", "--list"});
    ASSERT_EQ(told.exit_status, 0) << told.error;
    for (const char *name : {"blow", "direction", "hardness", "mass", "stiffness"}) {
        EXPECT_NE(told.out.find(name), std::string::npos) << name;
    }
    EXPECT_NE(told.out.find("Force-direction discrimination"), std::string::npos);
}

TEST(StudyCommand, WritesAProtocolAndNeverOverAnother) {
    const std::filesystem::path file = testing::fresh_folder("study_new") / "mine.toml";
    const testing::Ending told = study({"new", "direction", "--out", file});
    ASSERT_EQ(told.exit_status, 0) << told.error;
    const std::string shipped =
        testing::contents_of(testing::assets() / "protocols/direction.toml");
    EXPECT_EQ(testing::contents_of(file), shipped) << "with its comments";
    testing::expect_refused(study({"new", "mass", "--out", file}), "mine.toml: exists");
    EXPECT_EQ(testing::contents_of(file), shipped);
    EXPECT_EQ(study({"new", "direction", "--out", "-"}).out, shipped);
}

TEST(StudyCommand, RefusesNamesThatAreNoProtocolInOneLine) {
    testing::expect_refused(study({"new", "directions"}),
                            "blow, can_you_feel_it, direction, hardness");
    testing::expect_refused(study({"new"}), "--list");
    testing::expect_refused(study({"check", "/nonexistent/p.toml"}), "p.toml");
}

TEST(StudyCommand, ChecksWhatItHasWritten) {
    const std::filesystem::path file = testing::fresh_folder("study_check") / "s.toml";
    ASSERT_EQ(study({"new", "stiffness", "--out", file}).exit_status, 0);
    const testing::Ending good = study({"check", file});
    EXPECT_EQ(good.exit_status, 0) << good.out << good.error;
    EXPECT_EQ(good.error, "");
    EXPECT_NE(good.out.find("session, with breaks"), std::string::npos) << good.out;
    EXPECT_NE(good.out.find("simulated"), std::string::npos) << good.out;

    std::string text = testing::contents_of(file);
    const std::string gain = "K_P_V_per_rad = 6.0";
    text.replace(text.find(gain), gain.size(), "K_P_V_per_rad = 90.0");
    std::ofstream(file) << text;
    const testing::Ending bad = study({"check", file});
    EXPECT_EQ(bad.exit_status, 1);
    EXPECT_NE(bad.out.find("error: condition \"light press\""), std::string::npos) << bad.out;
    EXPECT_NE(bad.out.find("is unstable"), std::string::npos) << bad.out;
    EXPECT_NE(bad.error.find("2 errors"), std::string::npos) << bad.error;

    text.replace(text.find("K_P_V_per_rad = 90.0"), 20, "K_P_V_per_rad = 900.0");
    std::ofstream(file) << text;
    testing::expect_refused(study({"check", file}),
                            "K_P_V_per_rad is 900; it must be a number from 0");
}

TEST(StudyCommand, FindsWhatKeepsPersonsOutBeforeAStudyBegins) {
    const std::filesystem::path folder = testing::fresh_folder("study_check_person");
    std::string text = testing::contents_of(testing::assets() / "protocols/blow.toml");
    const std::string keys = R"(keys = ["right", "left"])";
    ASSERT_NE(text.find(keys), std::string::npos);
    text.replace(text.find(keys), keys.size(), R"(keys = ["right", "two"])");
    const std::filesystem::path file = folder / "s.toml";
    std::ofstream(file) << text;
    const testing::Ending bad = study({"check", file, "--no-simulation"});
    EXPECT_EQ(bad.exit_status, 1);
    EXPECT_EQ(bad.out.find("error: with a person: responses.keys has \"two\""), 0U) << bad.out;
    testing::expect_refused(study({"run", file}), "with a person: responses.keys has \"two\"");
    EXPECT_FALSE(std::filesystem::exists(folder / "s.study"));
}

TEST(StudyCommand, RefusesAStudyInThePlaceOfItsProtocol) {
    const std::filesystem::path file = testing::fresh_folder("study_check_study") / "s.study";
    study::create_study(file, {"s", "title = \"s\"", "1.0"}, study::utc_now());
    for (const char *const command : {"check", "plan"}) {
        testing::expect_refused(study({command, file}), "s.study: is a study, no protocol; name");
    }
    testing::expect_refused(study({"run", file, "--study", "other.study"}), "is a study already");
    std::filesystem::copy_file(file, file.parent_path() / "s.toml");
    testing::expect_refused(study({"check", file.parent_path() / "s.toml"}), "is a study");
}

TEST(StudyCommand, LeavesTheSimulationOutIfAsked) {
    const testing::Ending told =
        study({"check", testing::assets() / "protocols/mass.toml", "--no-simulation"});
    EXPECT_EQ(told.exit_status, 0) << told.out << told.error;
    EXPECT_EQ(told.out.find("force N"), std::string::npos) << told.out;
}

} // namespace
} // namespace springdrive::app

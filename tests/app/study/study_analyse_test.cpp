// Covers app/commands/study/study_{analyse,plan,pictures}.cpp, from outside; and docs/study.md's
// walk with each shipped protocol, shortened.
#include "tests/app/study/study_program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;
using testing::study;

void expect_picture(const fs::path &svg) {
    const std::string text = testing::contents_of(svg);
    EXPECT_NE(text.find("</svg>"), std::string::npos) << svg;
    EXPECT_EQ(text.find("nan"), std::string::npos) << svg;
}

double number(const std::string &text) { return std::stod(text); }

/// How many discs of a colour, as an RGB of SVG begins, are in a picture: one for each row that is
/// drawn, and one in the legend.
std::ptrdiff_t discs(const fs::path &svg, const std::string &colour) {
    const std::string text = testing::contents_of(svg);
    const std::regex disc("#gpPt6'[^>]*color='rgb\\(" + colour);
    return std::distance(std::sregex_iterator(text.begin(), text.end(), disc), {});
}

class ShippedProtocol : public ::testing::TestWithParam<std::string> {};

TEST_P(ShippedProtocol, ComesFromNewToTheFigure) {
    const std::string name = GetParam();
    const fs::path folder = testing::fresh_folder("study_walk_" + name);
    const fs::path protocol = folder / (name + ".toml");
    ASSERT_EQ(study({"new", name, "--out", protocol}).exit_status, 0);
    // A name that gnuplot would take for several cells of a table.
    std::ofstream(protocol) << std::regex_replace(
        testing::shortened(name), std::regex("\"fast strokes\""), "'#1 \"fast\", hard strokes'");
    ASSERT_EQ(study({"check", protocol, "--no-simulation"}).exit_status, 0);
    std::vector<std::string> run{"run",       protocol, "--participants", "2",        "--observer",
                                 "simulated", "--felt", "once",           "--spread", "0.1"};
    const testing::Ending ran = study(run);
    ASSERT_EQ(ran.exit_status, 0) << ran.error;
    const fs::path file = folder / (name + ".study");
    ASSERT_EQ(study({"status", file}).exit_status, 0);

    testing::expect_refused(study({"analyse", file, "--out", folder / "results"}),
                            "on simulated devices (--device simulated)");
    const testing::Ending analysed =
        study({"analyse", file, "--device", "simulated", "--out", folder / "results"});
    ASSERT_EQ(analysed.exit_status, 0) << analysed.error;
    EXPECT_NE(analysed.out.find("no person's"), std::string::npos) << analysed.out;
    const std::string thresholds = testing::contents_of(folder / "results/thresholds.csv");
    const std::vector<std::string> medians = testing::column_of(thresholds, "threshold");
    const std::vector<std::string> lows = testing::column_of(thresholds, "threshold_low");
    const std::vector<std::string> highs = testing::column_of(thresholds, "threshold_high");
    ASSERT_GE(medians.size(), 4U) << "two participants, two conditions or more";
    for (std::size_t i = 0; i < medians.size(); ++i) {
        EXPECT_LT(number(lows[i]), number(medians[i]));
        EXPECT_LT(number(medians[i]), number(highs[i]));
    }
    expect_picture(folder / "results/functions_P01.svg");
    expect_picture(folder / "results/functions_P02.svg");
    expect_picture(folder / "results/group.svg");
    EXPECT_EQ(discs(folder / "results/group.svg", "119"), std::ssize(medians) + 1);
    const std::vector<std::string> levels =
        testing::column_of(testing::contents_of(folder / "results/levels.csv"), "participant");
    EXPECT_EQ(discs(folder / "results/functions_P01.svg", " *0"),
              std::ranges::count(levels, "P01") + 1);
    if (name != "hardness") { // constant stimuli have no course
        expect_picture(folder / "results/traces_P02.svg");
    }
    // What cannot be written is told before anything is.
    const fs::path blocked = folder / "blocked";
    fs::create_directories(blocked / "group.svg");
    const testing::Ending told =
        study({"analyse", file, "--device", "simulated", "--out", blocked});
    testing::expect_refused(told, "group.svg: is a folder");
    EXPECT_EQ(told.out, "");
    testing::expect_one_line(study({"analyse", file, "--device", "usb"}), 1,
                             "there are none on usb devices");
}

INSTANTIATE_TEST_SUITE_P(All, ShippedProtocol,
                         ::testing::Values("blow", "direction", "hardness", "mass", "stiffness"),
                         [](const auto &of) { return of.param; });

TEST(StudyPlan, TellsWhatAPrecisionTakes) {
    const fs::path folder = testing::fresh_folder("study_plan");
    const fs::path protocol = testing::assets() / "protocols/stiffness.toml";
    const testing::Ending told = study({"plan", protocol, "--trials", "10,21,80", "--studies", "40",
                                        "--precision", "3", "--out", folder / "plan"});
    ASSERT_EQ(told.exit_status, 0) << told.error;
    EXPECT_NE(told.out.find("a factor of 3 takes"), std::string::npos) << told.out;
    expect_picture(folder / "plan/precision.svg");
    const std::string csv = testing::contents_of(folder / "plan/precision.csv");
    EXPECT_EQ(testing::column_of(csv, "trials"), (std::vector<std::string>{"10", "21", "80"}));
    const std::vector<std::string> widths = testing::column_of(csv, "width_of_most");
    EXPECT_LT(number(widths[2]), number(widths[0])) << "more trials tell more";

    testing::expect_refused(study({"plan", protocol, "--precision", "0.9"}), "--precision is 0.9");
    for (const char *const wrong : {"1.0", "1e-300", "1e308", "inf", "nan"}) {
        testing::expect_refused(study({"plan", protocol, "--precision", wrong}),
                                "it must be from 1.01 to 1000: a factor");
        testing::expect_refused(
            study({"plan", protocol, "--slope", wrong == std::string("1.0") ? "0" : wrong}),
            "slope is");
    }
    testing::expect_refused(study({"plan", protocol, "--trials", "0"}), "trials");
    const fs::path without = testing::without_expected("hardness", folder);
    testing::expect_refused(study({"plan", without}), "--threshold and --slope");
}

TEST(StudyCommandLine, NamesOptionsThatCouldBeMeant) {
    testing::expect_one_line(study({"run", "x.toml", "--particpant", "P01"}), 2, "--particpant");
}

} // namespace
} // namespace springdrive::app

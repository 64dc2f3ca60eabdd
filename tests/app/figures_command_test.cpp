// Covers app/commands/figures_command.cpp and app/figures: `springdrive figures` from outside.
#include "app/figures/figure.h"
#include "tests/support/devices.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

/// Columns of a CSV file by name; cells that are empty or not numbers are NaN.
std::map<std::string, std::vector<double>> columns_of(const std::filesystem::path &csv) {
    std::ifstream file(csv);
    std::map<std::string, std::vector<double>> columns;
    std::vector<std::string> names;
    std::string line;
    for (bool head = true; std::getline(file, line); head = false) {
        std::istringstream cells(line + ",");
        std::string cell;
        for (std::size_t i = 0; std::getline(cells, cell, ','); ++i) {
            if (head) {
                names.push_back(cell);
            } else {
                char *end = nullptr;
                const double number = std::strtod(cell.c_str(), &end);
                columns[names.at(i)].push_back(end == cell.c_str() ? NAN : number);
            }
        }
    }
    return columns;
}

double largest(const std::vector<double> &column) {
    double found = 0.0;
    for (const double cell : column) {
        found = std::max(found, std::abs(cell));
    }
    return found;
}

testing::Ending figures(const std::filesystem::path &out, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"figures", "--out", out.string()});
    return testing::run_program(more);
}

TEST(Figures, ComeOutOfOneCommand) {
    // The folder's name would need quoting in a shell.
    const std::filesystem::path folder =
        testing::fresh_folder("figures") / "it's \"my\" $HOME;" / "new";
    const testing::Ending ending = figures(folder);
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.out, "");
    for (const FigureMaker &figure : kFigures) {
        const std::string name(figure.name);
        const std::string svg = testing::contents_of(folder / (name + ".svg"));
        EXPECT_NE(svg.find("<svg"), std::string::npos) << name;
        EXPECT_NE(svg.find("</svg>"), std::string::npos) << name;
        EXPECT_NE(svg.find("PHANTOM 1.0"), std::string::npos) << name;
        EXPECT_GT(columns_of(folder / (name + ".csv")).size(), 4U) << name;
    }
    std::filesystem::remove_all(folder.parent_path().parent_path());
}

TEST(Figures, MeasuredStandsBesidePredicted) {
    const std::filesystem::path folder = testing::fresh_folder("measured");
    ASSERT_EQ(figures(folder, {"--q", "0,20,-15"}).exit_status, 0);

    auto stiffness = columns_of(folder / "fig2_stiffness.csv");
    for (std::size_t i = 0; i < stiffness["freq_hz"].size(); ++i) {
        const bool measurable = stiffness["freq_hz"][i] < 450.0;
        ASSERT_EQ(std::isfinite(stiffness["measured"][i]), measurable);
        if (stiffness["freq_hz"][i] <= 250.0) { // 1 % up to a quarter of the servo rate
            EXPECT_NEAR(stiffness["measured"][i] / stiffness["sampled"][i], 1.0, 0.01);
            EXPECT_NEAR(stiffness["measured_phase_deg"][i], stiffness["sampled_phase_deg"][i], 1.0);
        }
    }
    auto errors = columns_of(folder / "fig6_direction_error.csv");
    ASSERT_EQ(errors["normal_deg"].size(), 24U);
    for (std::size_t i = 0; i < 24; ++i) {
        EXPECT_DOUBLE_EQ(errors["normal_deg"][i], 15.0 * static_cast<double>(i));
        EXPECT_NEAR(errors["inverse_ideal_deg"][i], errors["inverse_predicted_deg"][i], 0.1);
        EXPECT_NEAR(errors["inverse_error_deg"][i], errors["inverse_predicted_deg"][i], 5.0);
    }
    EXPECT_LT(largest(errors["transpose_ideal_deg"]), 0.01);
    EXPECT_LT(largest(errors["transpose_error_deg"]), 5.0);
    EXPECT_GT(largest(errors["transpose_error_deg"]), 0.1);

    auto forces = columns_of(folder / "fig5_forces.csv");
    for (std::size_t map = 0; map < 2; ++map) {
        EXPECT_LT(std::hypot(forces["measured_outward_N"][map] - forces["predicted_outward_N"][map],
                             forces["measured_up_N"][map] - forces["predicted_up_N"][map]),
                  0.1); // friction, 0.04 N at each joint's end, and the stiffness times a count
    }
    auto spectrum = columns_of(folder / "fig7_direction_over_frequency.csv");
    EXPECT_NEAR(largest(spectrum["inverse_deg"]), 35.0, 0.01);
    EXPECT_LT(spectrum["transpose_lambda_1000_deg"].front(), 0.1);
    EXPECT_NEAR(spectrum["transpose_lambda_1000_deg"].back(), 35.0, 1.0); // K_L: the ellipsoid
    std::filesystem::remove_all(folder);
}

TEST(Figures, RepeatToTheLastByte) {
    const std::filesystem::path folder = testing::fresh_folder("repeat");
    for (const char *run : {"first", "second"}) {
        ASSERT_EQ(figures(folder / run,
                          {"--device-file", testing::assets() / "devices/phantom_premium_1_5.toml",
                           "--tuning-file", testing::assets() / "tunings/soft.toml"})
                      .exit_status,
                  0);
    }
    for (const auto &file : std::filesystem::directory_iterator(folder / "first")) {
        EXPECT_TRUE(testing::contents_of(file) ==
                    testing::contents_of(folder / "second" / file.path().filename()))
            << file.path();
    }
    std::filesystem::remove_all(folder);
}

TEST(Figures, SayWhatIsWrongInOneLine) {
    const std::filesystem::path folder = testing::fresh_folder("wrong");
    std::ofstream(folder / "file") << "in the way";
    testing::expect_one_line(testing::run_program({"figures"}), 2, "--out");
    testing::expect_one_line(figures(folder / "file" / "below"), 1, "below");
    testing::expect_one_line(figures(folder / "a", {"--q", "0,20"}), 2, "--q");
    testing::expect_one_line(figures(folder / "a", {"--q", "0,20,nan"}), 1, "--q");
    testing::expect_one_line(figures(folder / "a", {"--q", "0,45,-25"}), 1, "joint_limits");
    testing::expect_one_line(figures(folder / "a", {"--q", "0,-45,45"}), 1, "q3 - q2 is 90");
    testing::expect_one_line(figures(folder / "a", {"--q", "0,20,215"}), 1, "q3 is 215");
    testing::expect_one_line(figures(folder / "a", {"--device-seed", "0"}), 2, "--device-seed");
    testing::expect_one_line(figures(folder / "a", {"--tuning-file", "none.toml"}), 1, "none.toml");
    // A full disk: each write to a link to /dev/full fails.
    std::filesystem::create_directory(folder / "full");
    std::filesystem::create_symlink("/dev/full", folder / "full" / "fig3_ellipses.csv");
    testing::expect_one_line(figures(folder / "full"), 1, "fig3_ellipses.csv");
    EXPECT_GT(std::filesystem::file_size(folder / "full" / "fig2_stiffness.csv"), 1000U);
    std::filesystem::remove_all(folder);
}

TEST(Figures, AreOfTheResidualResistanceThatTheServoGives) {
    // 0.02 Ω is not permitted for windings that may be cold: the figures use, and report, the dR
    // that the servo gives.
    const std::filesystem::path folder = testing::fresh_folder("cold");
    std::string tuning = testing::contents_of(testing::assets() / "tunings/firm.toml");
    const std::size_t dR = tuning.find("dR_Ohm");
    tuning.replace(dR, tuning.find('\n', dR) - dR, "dR_Ohm = 0.02");
    std::ofstream(folder / "tuning.toml") << tuning;
    const testing::Ending ending =
        figures(folder / "out", {"--tuning-file", (folder / "tuning.toml").string()});
    EXPECT_EQ(ending.exit_status, 0);
    EXPECT_NE(ending.error.find("limits dR to 0.137"), std::string::npos) << ending.error;
    auto forces = columns_of(folder / "out" / "fig5_forces.csv");
    // What is observed allows no more: a motor whose R is up to 10 % above the smallest of its file
    // has a dR larger by that. Friction, and k_T and gains that differ by a few per cent: 10 %.
    const double spread_Ohm = 0.1 * testing::phantom_motor().resistance_Ohm;
    for (std::size_t map = 0; map < 2; ++map) {
        const double share = forces["measured_up_N"][map] / forces["predicted_up_N"][map];
        EXPECT_LT(share, 1.1);
        EXPECT_GT(share, 0.9 * 0.137 / (0.137 + spread_Ohm));
    }
    std::filesystem::remove_all(folder);
}

TEST(Figures, WithoutGnuplotTheNumbersStay) {
    const std::filesystem::path folder = testing::fresh_folder("no_gnuplot");
    const char *inherited = std::getenv("PATH"); // NOLINT(concurrency-mt-unsafe)
    const std::string path = inherited != nullptr ? inherited : "";
    setenv("PATH", folder.c_str(), 1); // NOLINT(concurrency-mt-unsafe)
    const testing::Ending ending = figures(folder / "out");
    setenv("PATH", path.c_str(), 1); // NOLINT(concurrency-mt-unsafe)
    testing::expect_one_line(ending, 1, "gnuplot-nox");
    for (const FigureMaker &figure : kFigures) {
        EXPECT_TRUE(std::filesystem::exists(folder / "out" / (std::string(figure.name) + ".csv")));
    }
    std::filesystem::remove_all(folder);
}

} // namespace
} // namespace springdrive::app

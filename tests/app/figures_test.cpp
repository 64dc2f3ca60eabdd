// Covers app/commands/{figures,chart}_command.cpp and app/figures, from outside; and the marks of
// speed and accuracy by themselves.
#include "app/figures/figure.h"
#include "app/figures/speed_accuracy_marks.h"
#include "engine/lab/charts/charts.h"
#include "tests/support/csv.h"
#include "tests/support/devices.h"
#include "tests/support/program.h"
#include "tests/support/variable.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;

/// Columns of a CSV file by name; cells that are empty or not numbers are NaN.
std::map<std::string, std::vector<double>> columns_of(const fs::path &csv) {
    const std::string text = testing::contents_of(csv);
    const std::vector<std::string> names = testing::parsed_csv(text).front();
    std::map<std::string, std::vector<double>> columns;
    for (const std::vector<double> &row : testing::parsed_numbers(text)) {
        for (std::size_t i = 0; i < row.size(); ++i) {
            columns[names.at(i)].push_back(row[i]);
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

std::set<std::string> files_in(const fs::path &folder) {
    std::set<std::string> names;
    for (const auto &file : fs::directory_iterator(folder)) {
        names.insert(file.path().filename());
    }
    return names;
}

testing::Ending run_into(const char *command, const fs::path &out,
                         std::vector<std::string> more = {}) {
    more.insert(more.begin(), {command, "--out", out.string()});
    return testing::run_program(more);
}

const std::vector<std::string> kPremium{"--device-file",
                                        testing::assets() / "devices/phantom_premium_1_5.toml",
                                        "--tuning-file", testing::assets() / "tunings/soft.toml"};

/// The quickest charts.
constexpr const char *kQuick = "motion_stiffness,servo_rate_direction";

TEST(Figures, MeasuredStandsBesidePredicted) {
    // The folder's name would need quoting in a shell.
    const fs::path folder = testing::fresh_folder("figures") / "it's \"my\" $HOME;" / "new";
    const testing::Ending ending = run_into("figures", folder, {"--q", "0,20,-15"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.out, "");
    for (const FigureMaker &figure : figure_makers()) {
        const std::string name(figure.name);
        const std::string svg = testing::contents_of(folder / (name + ".svg"));
        for (const char *part : {"<svg", "</svg>", "PHANTOM 1.0"}) {
            EXPECT_NE(svg.find(part), std::string::npos) << name << ": " << part;
        }
        EXPECT_GT(columns_of(folder / (name + ".csv")).size(), 4U) << name;
    }
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
}

TEST(Figures, WithoutGnuplotTheNumbersStayAndRepeatToTheLastByte) {
    const fs::path folder = testing::fresh_folder("no_gnuplot");
    ASSERT_EQ(run_into("figures", folder / "drawn", kPremium).exit_status, 0);
    const testing::Variable path("PATH", folder.string());
    testing::expect_one_line(run_into("figures", folder / "figures", kPremium), 1, "gnuplot-nox");
    std::set<std::string> numbers;
    for (const FigureMaker &figure : figure_makers()) {
        const std::string name(figure.name);
        EXPECT_TRUE(testing::contents_of(folder / "drawn" / (name + ".csv")) ==
                    testing::contents_of(folder / "figures" / (name + ".csv")))
            << name;
        EXPECT_NE(testing::contents_of(folder / "drawn" / (name + ".svg")).find("Premium 1.5"),
                  std::string::npos)
            << name;
        numbers.insert(name + ".csv");
    }
    EXPECT_EQ(files_in(folder / "figures"), numbers);
    testing::expect_one_line(
        run_into("chart", folder / "charts", {"--only", kQuick, "--repeats", "1"}), 1,
        "gnuplot-nox");
    EXPECT_EQ(files_in(folder / "charts"),
              (std::set<std::string>{"motion_stiffness.csv", "servo_rate_direction.csv"}));
}

/// A full disk: each write to a link to /dev/full fails.
TEST(Figures, NumbersThatCannotBeWrittenAreNamed) {
    const fs::path folder = testing::fresh_folder("full");
    for (const char *name : {"fig3_ellipses.csv", "motion_stiffness.csv"}) {
        fs::create_symlink("/dev/full", folder / name);
    }
    testing::expect_one_line(run_into("figures", folder), 1, "fig3_ellipses.csv");
    EXPECT_GT(fs::file_size(folder / "fig2_stiffness.csv"), 1000U);
    testing::expect_one_line(run_into("chart", folder, {"--only", kQuick}), 1,
                             "motion_stiffness.csv");
}

TEST(Figures, AreOfTheResidualResistanceThatTheServoGives) {
    // 0.02 Ω is not permitted for windings that may be cold: the figures use, and report, the dR
    // that the servo gives.
    const fs::path folder = testing::fresh_folder("cold");
    std::string tuning = testing::contents_of(testing::assets() / "tunings/firm.toml");
    const std::size_t dR = tuning.find("dR_Ohm");
    tuning.replace(dR, tuning.find('\n', dR) - dR, "dR_Ohm = 0.02");
    std::ofstream(folder / "tuning.toml") << tuning;
    const testing::Ending ending =
        run_into("figures", folder / "out", {"--tuning-file", (folder / "tuning.toml").string()});
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
}

TEST(ChartCommand, ThoseAskedForComeOutAsPicturesAndNumbers) {
    const fs::path folder = testing::fresh_folder("charts") / "new";
    const testing::Ending ending = run_into("chart", folder, {"--only", kQuick, "--repeats", "2"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.out, "");
    EXPECT_EQ(files_in(folder),
              (std::set<std::string>{"motion_stiffness.csv", "motion_stiffness.svg",
                                     "servo_rate_direction.csv", "servo_rate_direction.svg"}));
    const std::string svg = testing::contents_of(folder / "motion_stiffness.svg");
    for (const char *part : {"PHANTOM 1.0", "minimum of 2 repetitions", "inverse (18)",
                             "transpose, α by hand", "α 1000"}) {
        EXPECT_NE(svg.find(part), std::string::npos) << part;
    }
    const std::string csv = testing::contents_of(folder / "motion_stiffness.csv");
    EXPECT_TRUE(csv.starts_with("method,setting,cost_least_ns,cost_median_ns,cost_greatest_ns,"
                                "error,stable,machine\n"));
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 9); // a header, three and five points
    std::vector<std::string> premium = kPremium;
    premium.insert(premium.end(), {"--only", "servo_rate_direction", "--force"});
    ASSERT_EQ(run_into("chart", folder, premium).exit_status, 0);
    EXPECT_NE(testing::contents_of(folder / "servo_rate_direction.svg").find("Premium 1.5"),
              std::string::npos);
}

TEST(ChartCommand, AreNamedAsTheListSays) {
    charts::ChartSetting setting;
    setting.device = testing::phantom_1_0();
    setting.repeats = 1;
    std::set<std::string_view> names;
    for (const charts::ChartMaker &maker : charts::kCharts) {
        EXPECT_TRUE(names.insert(maker.name).second) << maker.name;
        if (maker.name.starts_with("servo_rate") || maker.name.starts_with("motion")) {
            EXPECT_EQ(maker.make(setting, [](double) {}).name, maker.name);
        }
    }
}

charts::ChartPoint point(const std::string &method, double cost_ns, double error,
                         bool stable = true) {
    return {method, "setting", {0.9 * cost_ns, cost_ns, 2.0 * cost_ns}, error, stable};
}

/// The value that an assignment gives to a name, as text.
std::string value_of(const ChartMarks &marks, const std::string &name) {
    const std::string &all = marks.assignments();
    const std::size_t start = all.find(name + " = ") + name.size() + 3;
    return all.substr(start, all.find("; ", start) - start);
}

double number_of(const ChartMarks &marks, const std::string &name) {
    return std::strtod(value_of(marks, name).c_str(), nullptr);
}

ChartMarks marks_of(const std::vector<charts::ChartPoint> &points) {
    charts::SpeedAccuracyChart chart;
    chart.points = points;
    return speed_accuracy_marks(chart, "note");
}

TEST(SpeedAccuracyMarks, NumberTheMethodsOfTheRows) {
    const ChartMarks marks =
        marks_of({point("a, b", 10, 1e-3), point("c", 1e3, 1e-3), point("a, b", 1e5, 1e-6)});
    EXPECT_EQ(value_of(marks, "legend"), "'\"a, b: setting\" \"c: setting\" '");
    EXPECT_EQ(value_of(marks, "method_of_rows"), "'1 2 1 '");
    EXPECT_EQ(value_of(marks, "footnote"), "'note'");
}

TEST(SpeedAccuracyMarks, RangesHoldEveryPointAndItsSpread) {
    const ChartMarks marks = marks_of({point("a", 10, 1e-3), point("a", 1e3, 1e-5)});
    EXPECT_LT(number_of(marks, "cost_low_s"), 9e-9);
    EXPECT_GT(number_of(marks, "cost_high_s"), 2e-6);
    EXPECT_LT(number_of(marks, "error_low"), 1e-5);
    EXPECT_GT(number_of(marks, "error_high"), 1e-3);
    EXPECT_EQ(number_of(marks, "error_of_zero"), 0.0);
    EXPECT_EQ(number_of(marks, "has_failures"), 0.0);
    EXPECT_EQ(number_of(marks, "error_of_none"), 0.0);
    const ChartMarks none = marks_of({point("a", 10, NAN, false), point("a", 10, INFINITY, false)});
    EXPECT_LT(number_of(none, "error_low"), number_of(none, "error_high"));
}

TEST(SpeedAccuracyMarks, ErrorsOfZeroAndFailuresWithoutAnErrorStandBeyondAllOthers) {
    const ChartMarks marks =
        marks_of({point("a", 10, 0.0), point("b", 10, 1e-5), point("c", 10, NAN, false)});
    EXPECT_LT(number_of(marks, "error_of_zero"), 1e-6);
    EXPECT_GT(number_of(marks, "error_of_zero"), number_of(marks, "error_low"));
    EXPECT_EQ(number_of(marks, "has_failures"), 1.0);
    EXPECT_GT(number_of(marks, "error_of_none"), 1e-5);
    EXPECT_LT(number_of(marks, "error_of_none"), number_of(marks, "error_high"));
    EXPECT_TRUE(std::isfinite(number_of(marks, "error_high")));
}

TEST(SpeedAccuracyMarks, RoundOffStandsWithZeroAndDoesNotStretchTheAxis) {
    const ChartMarks marks =
        marks_of({point("a", 10, 1e-3), point("a", 100, 1e-6), point("exact", 10, 1.4e-17)});
    EXPECT_GT(number_of(marks, "round_off"), 1.4e-17);
    EXPECT_LT(number_of(marks, "round_off"), 2e-17);
    EXPECT_GT(number_of(marks, "error_low"), 1e-10);
    EXPECT_GT(number_of(marks, "error_of_zero"), number_of(marks, "error_low"));
    // Six decades in steps, as by an integrator's order, are not round-off.
    const ChartMarks steps =
        marks_of({point("a", 10, 1e-3), point("a", 100, 1e-8), point("a", 1000, 1e-13)});
    EXPECT_EQ(number_of(steps, "round_off"), 0.0);
}

TEST(SpeedAccuracyMarks, TheLegendHasTheFirstAndTheLastSettingOfEachMethod) {
    for (const auto &[settings, legend] :
         std::vector<std::pair<std::vector<const char *>, std::string>>{
             {{"1000 µs", "500 µs", "0.9766 µs"}, "1000 … 0.9766 µs"},
             {{"250 Hz", "20 kHz"}, "250 Hz … 20 kHz"},
             {{"α 1000", "α 11000"}, "α 1000 … α 11000"},
             {{"1e-2", "1e-10"}, "1e-2 … 1e-10"},
             {{"exact"}, "exact"}}) {
        std::vector<charts::ChartPoint> points;
        for (const char *setting : settings) {
            points.push_back(point("a", 10, 1.0));
            points.back().setting = setting;
        }
        EXPECT_EQ(value_of(marks_of(points), "legend"), "'\"a: " + legend + "\" '");
    }
}

} // namespace
} // namespace springdrive::app

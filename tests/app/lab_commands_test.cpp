// Covers the commands that measure without a session, from outside:
// app/commands/{inspect,touch,figures,chart}_command.cpp and app/figures; and the marks of speed
// and accuracy by themselves.
#include "app/figures/figure.h"
#include "app/figures/speed_accuracy_marks.h"
#include "base/text.h"
#include "engine/lab/charts/charts.h"
#include "tests/support/csv.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/names.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <regex>
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

/// Its name would need quoting in a shell, and in gnuplot even more.
fs::path hard_folder(const std::string &name) {
    return testing::fresh_folder(name) / "< it's \"my\" $HOME;\n%d" / "| new";
}

/// The PHANTOM 1.0 in a file in `folder`, under another name.
fs::path named_device(const fs::path &folder, const std::string &name) {
    std::string text = testing::contents_of(testing::assets() / "devices/phantom_1_0.toml");
    const std::string own = "\nname = \"PHANTOM 1.0\"";
    text.replace(text.find(own), own.size(), "\nname = " + toml_string(name));
    fs::path file = folder / "named.toml";
    std::ofstream(file) << text;
    return file;
}

TEST(Figures, ShowNamesOfAnyCharactersAndEveryMark) {
    std::mt19937_64 random(53);
    const fs::path folder = hard_folder("names");
    fs::create_directories(folder);
    for (const int count :
         {1, 2, 12, 2500}) { // participants of the last: more than an argument holds
        std::vector<std::string> names;
        ChartMarks marks;
        const auto add = [&](const std::string &mark) {
            marks.add(mark, names.emplace_back(testing::random_name(random)));
        };
        for (const char *const mark : {"heading", "note", "level_label", "estimate_label"}) {
            add(mark);
        }
        const int panels = std::min(count, 12);
        std::vector<std::vector<double>> participants;
        std::vector<std::vector<double>> means;
        for (int i = 1; i <= panels; ++i) {
            add("title_" + std::to_string(i));
            means.push_back({1.0 * i, 2.0, 1.0, 4.0});
        }
        for (int number = 1; number <= count; ++number) {
            participants.push_back({1.0 + number % panels, 1.0 * number, 3.0, 2.5, 3.5});
        }
        marks.add("panels", panels);
        marks.add("highest_number", count);
        marks.add("is_logarithmic", 1.0);
        marks.add("participants", participants);
        marks.add("means", means);
        marks.add("lowest", 1.0);
        marks.add("highest", 4.0);
        draw(chart_of("study_group", marks, folder, "", "group.svg"), Existing::replace);
        const std::string svg = testing::contents_of(folder / "group.svg");
        for (const std::string &name : names) {
            EXPECT_TRUE(testing::is_in_svg(svg, name)) << name;
        }
        const auto discs_of = [&svg](const std::string &mark) {
            const std::regex one("#" + mark + "'[^>]*color='rgb\\(");
            return std::distance(std::sregex_iterator(svg.begin(), svg.end(), one), {});
        };
        EXPECT_EQ(discs_of("gpPt6"), count + 1) << "with that of the legend";
        EXPECT_EQ(discs_of("gpPt4"), panels + 1);
    }
    EXPECT_EQ(files_in(folder), std::set<std::string>{"group.svg"});
}

/// Of the numbers beside the vertical axis, which are leftmost: how high each is, from below [px].
std::vector<double> heights_of_numbers(const std::string &svg) {
    const std::regex label("translate\\(([^,]*),([^)]*)\\)\"[^>]*text-anchor=\"end\">\\s*<text>"
                           "(?!</text>)");
    std::map<double, std::vector<double>> heights;
    for (std::sregex_iterator one(svg.begin(), svg.end(), label), end; one != end; ++one) {
        heights[std::stod(one->str(1))].push_back(-std::stod(one->str(2)));
    }
    std::vector<double> leftmost =
        heights.empty() ? std::vector<double>() : heights.begin()->second;
    std::ranges::sort(leftmost);
    return leftmost;
}

/// A group of two: the interval of the mean may cover any number of decades.
TEST(Figures, HaveLegibleNumbersAtAnySpread) {
    const fs::path folder = testing::fresh_folder("spread");
    std::mt19937_64 random(56);
    std::uniform_real_distribution<double> decades(-4.0, std::log10(190.0));
    std::uniform_real_distribution<double> lowest(0.0, 1.0);
    for (int i = 0; i < 25; ++i) {
        const double spread = i == 0 ? 9.0 : std::pow(10.0, decades(random)); // in decades
        const double low = std::pow(10.0, lowest(random) - (spread > 2.0 ? 0.5 * spread : 0.0));
        const double high = low * std::pow(10.0, spread);
        ChartMarks marks;
        for (const char *const text : {"heading", "note", "level_label", "title_1"}) {
            marks.add(text, "text");
        }
        marks.add("estimate_label", "");
        marks.add("panels", 1.0);
        marks.add("highest_number", 2.0);
        marks.add("is_logarithmic", 1.0);
        marks.add("participants", {{1.0, 1.0, low, low, low}, {1.0, 2.0, high, high, high}});
        marks.add("means", {{1.0, low, low, high}});
        marks.add("lowest", low);
        marks.add("highest", high);
        draw(chart_of("study_group", marks, folder, "", "group.svg"), Existing::replace);
        const std::vector<double> heights =
            heights_of_numbers(testing::contents_of(folder / "group.svg"));
        EXPECT_GE(heights.size(), 2U) << spread << " decades";
        constexpr double kLetters_px = 13.0;
        for (std::size_t k = 1; k < heights.size(); ++k) {
            EXPECT_GT(heights[k] - heights[k - 1], kLetters_px) << spread << " decades";
        }
    }
}

TEST(Figures, NameTheirDevice) {
    std::mt19937_64 random(54);
    const fs::path folder = hard_folder("named_device");
    fs::create_directories(folder);
    for (int i = 0; i < 4; ++i) {
        const std::string name = testing::random_name(random);
        const fs::path svg = folder / ("map" + std::to_string(i) + ".svg");
        const testing::Ending ending =
            testing::run_program({"stability", "--map", "kp=1:100,dR", "--steps", "3", "--out", svg,
                                  "--device-file", named_device(folder, name)});
        ASSERT_EQ(ending.exit_status, 0) << ending.error;
        EXPECT_TRUE(testing::is_in_svg(testing::contents_of(svg), name)) << name;
    }
}

TEST(Figures, MeasuredStandsBesidePredicted) {
    const fs::path folder = hard_folder("figures");
    std::mt19937_64 random(55);
    const std::string device = testing::random_name(random);
    const testing::Ending ending =
        run_into("figures", folder,
                 {"--q", "0,20,-15", "--device-file",
                  named_device(testing::fresh_folder("figures_of"), device)});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.out, "");
    for (const FigureMaker &figure : figure_makers()) {
        const std::string name(figure.name);
        const std::string svg = testing::contents_of(folder / (name + ".svg"));
        for (const char *part : {"<svg", "</svg>"}) {
            EXPECT_NE(svg.find(part), std::string::npos) << name << ": " << part;
        }
        EXPECT_TRUE(testing::is_in_svg(svg, device)) << name << " lacks " << device;
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
        // What is not known of a drawn motor turns its force by 5°, where the map turns it back
        // less.
        EXPECT_NEAR(errors["inverse_error_deg"][i], errors["inverse_predicted_deg"][i], 8.0);
    }
    EXPECT_LT(largest(errors["transpose_ideal_deg"]), 0.01);
    EXPECT_LT(largest(errors["transpose_error_deg"]), 5.0);
    EXPECT_GT(largest(errors["transpose_error_deg"]), 0.1);

    auto forces = columns_of(folder / "fig5_forces.csv");
    for (std::size_t map = 0; map < 2; ++map) {
        // A motor whose R is not known apart from V_b has its dR held up, which costs all of them
        // stiffness (drive_gains.h); friction is 0.04 N at each joint's end.
        const double predicted_N =
            std::hypot(forces["predicted_outward_N"][map], forces["predicted_up_N"][map]);
        EXPECT_LT(std::hypot(forces["measured_outward_N"][map] - forces["predicted_outward_N"][map],
                             forces["measured_up_N"][map] - forces["predicted_up_N"][map]),
                  0.1 + 0.25 * predicted_N);
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
    return all.substr(start, all.find('\n', start) - start);
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

using nlohmann::json;

const std::string kScenes = SPRINGDRIVE_ASSET_DIR "/scenes/";
const std::string kSphere = "sphere:1280";

testing::Ending run_on_scene(const char *command, std::vector<std::string> options) {
    options.insert(options.begin(), command);
    return testing::run_program(options);
}

/// Without the model, which takes seconds to measure.
testing::Ending inspect(const std::string &scene) {
    return run_on_scene("inspect", {scene, "--no-model"});
}

json said_by(const char *command, std::vector<std::string> options) {
    options.insert(options.end(), {"--json", "-"});
    const testing::Ending ending = run_on_scene(command, options);
    EXPECT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.error, "");
    return json::parse(ending.out);
}
json inspected(const std::string &scene) { return said_by("inspect", {scene, "--no-model"}); }
json touched(std::vector<std::string> options) { return said_by("touch", std::move(options)); }

void expect_says(const std::string &text, const std::vector<const char *> &parts) {
    for (const char *part : parts) {
        EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
    }
}

TEST(InspectCommand, TellsWhatTheNodesAreMadeOf) {
    const json said = inspected(kScenes + "compliance.gltf");
    EXPECT_EQ(said["file_bytes"], std::filesystem::file_size(kScenes + "compliance.gltf"));
    EXPECT_TRUE(said["in_metres"]);
    const std::vector<std::pair<std::string, double>> expected{
        {"rigid", 0.0}, {"firm", 0.25}, {"medium", 0.5}, {"soft", 0.75}, {"softest", 0.9}};
    ASSERT_EQ(said["nodes"].size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        EXPECT_EQ(said["nodes"][i]["name"], expected[i].first);
        EXPECT_EQ(said["nodes"][i]["eta"], expected[i].second);
        EXPECT_EQ(said["nodes"][i]["triangles"], 12);
        EXPECT_EQ(said["nodes"][i]["one_sided_triangles"], 12);
        EXPECT_EQ(said["nodes"][i]["two_sided_triangles"], 0);
    }
    EXPECT_NEAR(said["lower_m"][0], -0.061, 1e-8); // single precision in the file
    EXPECT_NEAR(said["upper_m"][2], 0.015, 1e-8);
}

TEST(InspectCommand, TellsLessonPreparationAndFit) {
    const json lesson = inspected(kScenes + "wrong_direction.gltf")["lesson"];
    EXPECT_EQ(lesson["title"], "The wrong direction");
    EXPECT_NEAR(lesson["point_m"][2], 0.0358, 1e-12);
    EXPECT_GT(lesson["normal"][1], 0.9);
    expect_says(inspect(kScenes + "wrong_direction.gltf").out,
                {"title     The wrong direction", "feel      Press on the orange"});
    EXPECT_FALSE(inspected(kSphere).contains("lesson"));

    const json block = inspected(kScenes + "stepped_block.gltf");
    EXPECT_EQ(block["mesh"]["triangles_given"], block["mesh"]["triangles_kept"]);
    EXPECT_EQ(block["mesh"]["components"], 1);
    EXPECT_EQ(block["mesh"]["closed_components"], 1);
    EXPECT_EQ(block["mesh"]["open_edges"], 0);
    EXPECT_GT(block["mesh"]["welded_vertices"], 0); // flat faces, each with its own corners
    EXPECT_GT(block["bytes"], 0);
    EXPECT_GE(block["preparation_s"], 0.0);
    EXPECT_TRUE(block["remarks"].empty());

    const json fitted = inspected(kScenes + "organic.gltf");
    EXPECT_FALSE(fitted["in_metres"]);
    EXPECT_GT(fitted["metres_per_unit"], 0.0);
    EXPECT_LT(fitted["metres_per_unit"], 1.0);
    expect_says(inspect(kScenes + "organic.gltf").out, {"fitted to the workspace"});

    const testing::Ending table = inspect(kSphere);
    EXPECT_EQ(table.error, "");
    expect_says(table.out, {"metres of the device's frame", "100.00 mm", "triangles kept",
                            "can be touched", "closed surfaces", "bytes per triangle"});
    EXPECT_EQ(table.out.find("remark"), std::string::npos) << table.out;
}

TEST(InspectCommand, TellsWhichModelTheSceneWouldGetAndRemembersIt) {
    const testing::Variable cache("XDG_CACHE_HOME", testing::fresh_folder("inspect_cache"));
    const std::string scene = kScenes + "profile.gltf";
    const json model = said_by("inspect", {scene})["model"]; // progress is for terminals
    ASSERT_EQ(model["axes"].size(), 5U);
    for (const json &axis : model["axes"]) {
        EXPECT_EQ(axis["candidates"].back()["verdict"], "meets"); // the full model
    }
    EXPECT_EQ(model["axes"][2]["name"], "joints");
    EXPECT_EQ(model["axes"][2]["chosen"], "2");
    // Times would differ if it were measured again.
    EXPECT_EQ(said_by("inspect", {scene})["model"], model);
    expect_says(run_on_scene("inspect", {scene}).out,
                {"model: force to 0.1 N", "<- selected", "transpose_on_the_fly",
                 "relative to the full model", "per tick instead of"});
    EXPECT_NE(said_by("inspect", {scene, "--fresh"})["model"], model);
}

TEST(InspectCommand, ASceneOfNothingButThinTrianglesIsRefused) {
    const std::filesystem::path file = testing::fresh_folder("inspect_thin") / "thin.gltf";
    std::ofstream(file) << R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{)"
                        << R"("primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{)"
                        << R"("bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)"
                        << R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{)"
                        << R"("byteLength":36,"uri":"data:;base64,)" // three points in a line
                        << R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAQAAAAAAAAAAA"}]})";
    testing::expect_refused(inspect(file), file.string() + ": has nothing to touch");
}

TEST(TouchCommand, TellsFiguresOfEveryPath) {
    for (const char *path : {"press", "slide", "lissajous", "rain", "random"}) {
        const json said = touched({kSphere, "--path", path, "--steps", "4000", "--check", "20"});
        EXPECT_EQ(said["path"], path);
        EXPECT_EQ(said["triangles_given"], 1280);
        EXPECT_EQ(said["triangles_kept"], 1280);
        EXPECT_EQ(said["shapes"], 0);
        EXPECT_EQ(said["steps"], 4000);
        EXPECT_GT(said["steps_in_contact"], 50) << path;
        EXPECT_GT(said["bytes"], 100 * 1280) << path;
        for (const char *times : {"contact_ns", "contact_floor_ns", "free_ns", "free_floor_ns"}) {
            ASSERT_TRUE(said[times].is_object()) << path << ' ' << times;
            EXPECT_GT(said[times]["median"], 0.0);
            EXPECT_GE(said[times]["p99"], said[times]["median"]);
            EXPECT_GE(said[times]["p99.9"], said[times]["p99"]);
            EXPECT_GE(said[times]["max"], said[times]["p99.9"]);
        }
        EXPECT_LE(said["contact_floor_ns"]["median"], said["contact_ns"]["median"]);
        EXPECT_EQ(said["pop_throughs"], 0) << path;
        EXPECT_EQ(said["stuck_steps"], 0) << path;
        EXPECT_GE(said["steps_checked"], 20) << path;
        EXPECT_LT(said["largest_lag_m"], 1e-6) << path;
        EXPECT_GT(said["largest_sphere_direction_error_deg"], 0.1) << path; // caused by its facets
    }
    const json file =
        touched({kScenes + "stepped_block.gltf", "--path", "press", "--steps", "3000"});
    EXPECT_GT(file["steps_in_contact"], 100);
    EXPECT_FALSE(file.contains("largest_sphere_direction_error_deg"));
}

TEST(TouchCommand, WritesEveryStepAsCsv) {
    const std::filesystem::path folder = testing::fresh_folder("touch_files");
    const testing::Ending ending = run_on_scene(
        "touch", {kSphere, "--steps", "300", "--check", "all", "--csv", folder / "steps.csv",
                  "--json", folder / "figures.json", "--strict"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.out, "");
    const json said = json::parse(testing::contents_of(folder / "figures.json"));
    EXPECT_EQ(said["steps"], 300);
    EXPECT_EQ(said["steps_sampled"], said["steps_to_sample"]);
    EXPECT_EQ(said["steps_sampled"], said["steps_in_contact"]);
    EXPECT_EQ(said["steps_sampled_lagging"], 0);
    const std::string csv = testing::contents_of(folder / "steps.csv");
    EXPECT_EQ(csv.substr(0, csv.find('\n')), "t,x,y,z,px,py,pz,nx,ny,nz,constraints,ns,lag,still");
    int rows = 0;
    int touching = 0;
    for (const std::vector<double> &row : testing::parsed_numbers(csv)) {
        ASSERT_EQ(row.size(), 14U);
        EXPECT_EQ(row[12] >= 0.0, row[10] > 0.0); // each in contact is checked; else NaN
        EXPECT_FALSE(row[12] >= 1e-6);
        EXPECT_LE(row[13], row[0] + 1e-9);
        EXPECT_NEAR(row[0], 1e-3 * rows, 1e-9);
        const double normal = row[7] * row[7] + row[8] * row[8] + row[9] * row[9];
        EXPECT_NEAR(normal, row[10] > 0.0 ? 1.0 : 0.0, 1e-12);
        touching += row[10] > 0.0 ? 1 : 0;
        ++rows;
    }
    EXPECT_EQ(rows, 300);
    EXPECT_GT(touching, 200);
}

TEST(TouchCommand, SaysWhatItCouldHaveMissed) {
    const json few = touched({kSphere, "--steps", "3000", "--check", "100"});
    EXPECT_EQ(few["steps_sampled"], 100);
    EXPECT_GT(few["steps_to_sample"], 1000);
    EXPECT_NEAR(few["rate_not_excluded"].get<double>(), 0.0295, 1e-4); // 1 − 0.05^(1/100)
    EXPECT_EQ(few["confidence"], 0.95);
    expect_says(run_on_scene("touch", {kSphere, "--steps", "3000", "--check", "100"}).out,
                {"a rate below 1 in 33 could have been missed (95 %)"});
    expect_says(run_on_scene("touch", {kSphere, "--steps", "500", "--seed", "7"}).out,
                {"1280 of 1280", "slide", "seed 7", "in contact", "pop-throughs", "stuck",
                 "largest lag", "error from sphere", "all that were in contact",
                 "longest standstill"});
}

TEST(TouchCommand, FollowsAPathFromAFile) {
    const std::string path = testing::fresh_folder("touch_path") / "hand.csv";
    std::ofstream(path) << "0,0,0.06,0\n0.1,0,0.048,0\n0.2,0,0.06,0\n";
    const json said = touched({kSphere, "--path", path});
    EXPECT_EQ(said["steps"], 201); // both ends of 0.2 s at 1 kHz
    EXPECT_GT(said["steps_in_contact"], 20);
    EXPECT_FALSE(said.contains("seed"));
    EXPECT_EQ(touched({kSphere, "--path", path, "--servo-hz", "500"})["steps"], 101);
    EXPECT_EQ(touched({kSphere, "--path", path, "--steps", "40"})["steps"], 40);
}

TEST(TouchCommand, RepeatsARunToTheLastBit) {
    const auto motion = [](const std::string &seed) {
        json said = touched({kSphere, "--path", "random", "--steps", "3000", "--seed", seed});
        for (const char *of_the_clock :
             {"preparation_s", "contact_ns", "contact_floor_ns", "free_ns", "free_floor_ns"}) {
            said.erase(of_the_clock);
        }
        return said;
    };
    EXPECT_EQ(motion("3"), motion("3"));
    EXPECT_NE(motion("3"), motion("4"));
}

} // namespace
} // namespace springdrive::app

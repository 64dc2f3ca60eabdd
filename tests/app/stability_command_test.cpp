// Covers app/commands/stability_command.cpp, stability_options.cpp and stability_report.cpp, from
// outside.
#include "engine/lab/limits/stability_limits.h"
#include "tests/support/devices.h"
#include "tests/support/program.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

using Json = nlohmann::json;

testing::Ending stability(std::vector<std::string> options) {
    options.insert(options.begin(), "stability");
    return testing::run_program(options);
}

Json json_of(std::vector<std::string> options) {
    options.insert(options.end(), {"--json", "-"});
    return Json::parse(stability(options).out);
}

TEST(StabilityCommand, ExitsByTheAnswer) {
    const testing::Ending good = stability({});
    EXPECT_EQ(good.exit_status, 0) << good.error;
    EXPECT_NE(good.out.find("predicted  stable"), std::string::npos) << good.out;
    EXPECT_NE(good.out.find("simulated  stable"), std::string::npos) << good.out;
    const testing::Ending bad = stability({"--kp", "60"});
    EXPECT_EQ(bad.exit_status, 3);
    EXPECT_EQ(bad.error, "");
    EXPECT_NE(bad.out.find("predicted  UNSTABLE"), std::string::npos) << bad.out;
    EXPECT_NE(bad.out.find("simulated  UNSTABLE"), std::string::npos) << bad.out;
}

TEST(StabilityCommand, SaysWhyTheTwoMayDiffer) {
    // Just below the predicted limit, where encoder counts sustain a vibration.
    const testing::Ending ending = stability({"--kp", "29.5"});
    EXPECT_EQ(ending.exit_status, 3);
    EXPECT_NE(ending.out.find("predicted  stable"), std::string::npos) << ending.out;
    EXPECT_NE(ending.out.find("simulated  UNSTABLE"), std::string::npos) << ending.out;
    EXPECT_NE(ending.out.find("they differ because"), std::string::npos) << ending.out;
}

TEST(StabilityCommand, FindsTheLimitsOfOneParameter) {
    const loops::StabilityParameter &kp = *loops::stability_parameter_named("kp");
    const std::vector<limits::StabilityLimit> truth =
        limits::predicted_limits(testing::firm(), kp, {1.0, 100.0});
    ASSERT_EQ(truth.size(), 1U);
    const std::vector<std::string> options{"--vary", "kp", "--from", "1", "--to", "100"};
    const Json json = json_of(options);
    EXPECT_TRUE(json["stable"]);
    EXPECT_EQ(json["vary"], "kp");
    EXPECT_EQ(json["unit"], "V/rad");
    EXPECT_EQ(json["from"], 1.0);
    EXPECT_EQ(json["to"], 100.0);
    EXPECT_TRUE(json["throughout"].is_null());
    ASSERT_EQ(json["limits"].size(), 1U);
    const Json &limit = json["limits"][0];
    EXPECT_EQ(limit["stable"], "below");
    EXPECT_EQ(limit["predicted"].get<double>(), truth[0].predicted);
    EXPECT_EQ(limit["limited_by"]["motor"], truth[0].worst.motor + 1);
    EXPECT_EQ(limit["limited_by"]["hand"], truth[0].worst.hand.name);
    EXPECT_NEAR(limit["simulated_without_effects"].get<double>(), truth[0].predicted,
                0.02 * truth[0].predicted);
    EXPECT_LT(limit["simulated"].get<double>(), limit["simulated_with_friction"].get<double>());
    EXPECT_NEAR(limit["ratio"].get<double>(), limit["simulated"].get<double>() / truth[0].predicted,
                1e-12);
    const testing::Ending table = stability(options);
    EXPECT_EQ(table.exit_status, 0);
    EXPECT_NE(table.out.find("K_P from 1 to 100 V/rad: one limit"), std::string::npos) << table.out;
    EXPECT_NE(table.out.find("30.01"), std::string::npos) << table.out;
}

/// The side of the limit, 30 V/rad, on which a range lies; the exit status applies to the loop with
/// the given values.
TEST(StabilityCommand, SaysWhereThereIsNoLimit) {
    struct Range {
        std::vector<std::string> options;
        std::string throughout;
        int exit_status;
    };
    for (const Range &range :
         {Range{{"--vary", "kp", "--from", "1", "--to", "2"}, "stable", 0},
          Range{{"--vary", "kp", "--from", "60", "--to", "70"}, "unstable", 0},
          Range{{"--vary", "kp", "--from", "1", "--to", "2", "--kp", "60"}, "stable", 3},
          Range{{"--vary", "dR", "--from", "-2", "--to", "-1"}, "unstable", 0}}) {
        const testing::Ending ending = stability(range.options);
        EXPECT_EQ(ending.exit_status, range.exit_status);
        EXPECT_NE(
            ending.out.find("no limit within it, predicted " + range.throughout + " throughout\n"),
            std::string::npos)
            << ending.out;
        const Json json = json_of(range.options);
        EXPECT_TRUE(json["limits"].empty());
        EXPECT_EQ(json["throughout"], range.throughout);
    }
}

TEST(StabilityCommand, KnowsEveryLoopThatCanBeTyped) {
    const auto eigenvalue = [](const std::vector<std::string> &options) {
        return json_of(options)["predicted"]["largest_eigenvalue"].get<double>();
    };
    loops::StabilityCase which = testing::firm();
    EXPECT_EQ(eigenvalue({}), loops::worst_member(which).eigenvalue);
    which.freedom = loops::Freedom::three_motors;
    EXPECT_EQ(eigenvalue({"--motors", "3"}), loops::worst_member(which).eigenvalue);
    which.tuning.map = control::MotionMap::inverse;
    which.q_rad = Vector3(10.0, -5.0, 30.0) * std::numbers::pi / 180.0;
    EXPECT_EQ(eigenvalue({"--motors", "3", "--kinematics", "inverse", "--q", "10,-5,30"}),
              loops::worst_member(which).eigenvalue);
    which = testing::firm();
    which.hands = {loops::no_hand()};
    which.period_s = 1.0 / 2500.0;
    which.delay_periods = 2;
    EXPECT_EQ(eigenvalue({"--no-hand", "--servo-hz", "2500", "--delay", "2"}),
              loops::worst_member(which).eigenvalue);
    which.delay_periods = 1.25;
    EXPECT_EQ(eigenvalue({"--no-hand", "--servo-hz", "2500", "--delay", "1.25"}),
              loops::worst_member(which).eigenvalue);
    which = testing::firm();
    which.drive = device::AmplifierKind::current_drive;
    which.wall = {500.0, 1.5};
    EXPECT_EQ(
        eigenvalue({"--drive", "current", "--wall-stiffness", "500", "--wall-damping", "1.5"}),
        loops::worst_member(which).eigenvalue);
    which = testing::firm();
    which.net_resistance_Ohm = -0.05;
    EXPECT_EQ(eigenvalue({"--dR", "-0.05"}), loops::worst_member(which).eigenvalue);
    which = testing::firm();
    which.rotor = loops::driven_load(which, {1, loops::no_hand()}).damping_Nms_per_rad(0, 0) > 0.0
                      ? device::RotorLoad{3e-5, 1e-4, 0.0}
                      : device::RotorLoad{};
    EXPECT_EQ(eigenvalue({"--inertia", "3e-5", "--damping", "1e-4"}),
              loops::worst_member(which).eigenvalue);
}

/// The printed limit for a wall without B is the limit found for such a wall: motor 3, the weakest.
TEST(StabilityCommand, TellsColgateAndSchenkelsLine) {
    const testing::Ending ending = stability(
        {"--drive", "current", "--wall-damping", "0", "--no-hand", "--vary", "wall-stiffness"});
    const std::string head = "2b/(T(1 + 2d) + 2/ω)";
    const std::size_t line = ending.out.find(head);
    ASSERT_NE(line, std::string::npos) << ending.out;
    const double told = std::stod(ending.out.substr(line + head.size()));
    const std::size_t row = ending.out.find("up to", line + head.size());
    ASSERT_NE(row, std::string::npos) << ending.out;
    const double found = std::stod(ending.out.substr(row + 5));
    EXPECT_NEAR(found / told, 1.0, 0.01); // bT/6J for light rotors, and four digits
}

TEST(StabilityCommand, RefusesWhatMeansNothingToTheLoop) {
    testing::expect_refused(stability({"--motors", "3", "--vary", "inertia"}), "--vary inertia");
    testing::expect_refused(stability({"--motors", "3", "--inertia", "1e-5"}), "--inertia");
    testing::expect_refused(stability({"--drive", "current", "--vary", "kp"}), "spring drive");
    testing::expect_refused(stability({"--vary", "wall-stiffness"}), "--drive current");
    testing::expect_refused(stability({"--kinematics", "inverse", "--vary", "alpha"}), "transpose");
    testing::expect_refused(stability({"--no-hand", "--vary", "hand-mass"}), "--no-hand");
    testing::expect_refused(stability({"--map", "kp,wall-damping", "--out", "none.svg"}),
                            "--map wall-damping");
}

/// Its rows have their own drives, tunings and servos.
TEST(StabilityCommand, RefusesWhatMeansNothingToTheTable) {
    for (const loops::StabilityParameter &parameter : loops::stability_parameters()) {
        const std::string name(parameter.name);
        if (!name.starts_with("hand")) {
            const std::string option = name == "d"   ? "--delay"
                                       : name == "T" ? "--servo-hz"
                                                     : "--" + name;
            testing::expect_refused(stability({"--table", option, "1"}),
                                    option + " excludes --table");
        }
    }
    testing::expect_refused(stability({"--table", "--tuning-file", "x.toml"}),
                            "--tuning-file excludes --table");
    testing::expect_refused(stability({"--table", "--kinematics", "inverse"}),
                            "--kinematics excludes --table");
    testing::expect_refused(stability({"--table", "--drive", "current"}),
                            "--drive excludes --table");
    testing::expect_refused(stability({"--table", "--motors", "3"}), "--motors excludes --table");
    // Options that it does use are accepted until their values are checked.
    testing::expect_refused(stability({"--table", "--hand-mass", "-0.1"}), "0 to 100");
    testing::expect_refused(stability({"--table", "--q", "nan,0,0"}), "--q");
    testing::expect_refused(stability({"--table", "--no-hand", "--device-file", "none.toml"}),
                            "none.toml");
}

TEST(StabilityCommand, DrawsAMap) {
    const std::filesystem::path folder = testing::fresh_folder("stability_map");
    const testing::Ending ending = stability(
        {"--map", "kp=1:100,dR=0.1:2", "--steps", "4", "--no-hand", "--out", folder / "map.svg"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    const std::string svg = testing::contents_of(folder / "map.svg");
    EXPECT_NE(svg.find("<svg"), std::string::npos);
    EXPECT_NE(svg.find("</svg>"), std::string::npos);
    std::istringstream csv(testing::contents_of(folder / "map.csv"));
    std::string line;
    std::getline(csv, line);
    EXPECT_EQ(line, "kp,dR,largest_eigenvalue,stable_simulated,remaining_m_per_s");
    int rows = 0;
    int gaps = 0;
    while (std::getline(csv, line)) {
        if (line.empty()) {
            ++gaps;
            continue;
        }
        ++rows;
        std::istringstream cells(line);
        std::vector<double> row;
        for (std::string cell; std::getline(cells, cell, ',');) {
            row.push_back(std::stod(cell));
        }
        ASSERT_EQ(row.size(), 5U) << line;
        loops::StabilityCase which = testing::firm();
        which.hands = {loops::no_hand()};
        which.tuning.K_P_V_per_rad = row[0];
        which.net_resistance_Ohm = row[1];
        EXPECT_NEAR(row[2], loops::worst_member(which).eigenvalue, 1e-6) << line;
    }
    EXPECT_EQ(rows, 16);
    EXPECT_EQ(gaps, 4); // after each row of the grid
    std::filesystem::remove_all(folder);
}

TEST(StabilityCommand, RefusesNonsenseWithTheRange) {
    testing::expect_refused(stability({"--kp", "-1"}), "0 to 10000");
    testing::expect_refused(stability({"--kp", "nan"}), "kp");
    testing::expect_refused(stability({"--dR", "0"}), "not 0");
    testing::expect_refused(stability({"--servo-hz", "0"}), "1 to 1");
    testing::expect_refused(stability({"--servo-hz", "nan"}), "--servo-hz");
    testing::expect_refused(stability({"--delay", "-1"}), "0 to 8");
    testing::expect_refused(stability({"--delay", "9"}), "0 to 8");
    testing::expect_refused(stability({"--delay", "8.001"}), "0 to 8");
    testing::expect_refused(stability({"--delay", "nan"}), "0 to 8");
    testing::expect_refused(stability({"--eta", "1.1"}), "0 to 1");
    testing::expect_refused(stability({"--eta="}), "--eta: 1 required VALUE missing");
    testing::expect_refused(stability({"--eta"}), "--eta: 1 required VALUE missing");
    testing::expect_refused(stability({"--hand-mass", "-0.1"}), "0 to 100");
    testing::expect_refused(stability({"--hand-mass", "0.1", "--no-hand"}), "--no-hand");
    testing::expect_refused(stability({"--inertia", "0"}), "inertia");
    testing::expect_refused(stability({"--inertia", "-1e-5"}), "1e-12");
    testing::expect_refused(stability({"--damping", "-1"}), "0 to 1000");
    testing::expect_refused(stability({"--inertia", "1e-5", "--motors", "3"}), "--motors");
    testing::expect_refused(stability({"--motors", "2"}), "--motors");
    testing::expect_refused(stability({"--drive", "hydraulic"}), "--drive");
    testing::expect_refused(stability({"--q", "0,20"}), "--q");
    testing::expect_refused(stability({"--q", "nan,0,0"}), "--q");
    testing::expect_refused(stability({"--q", "0,200,0"}), "q");
    testing::expect_refused(stability({"--tuning-file", "none.toml"}), "none.toml");
    testing::expect_refused(stability({"--device-file", "none.toml"}), "none.toml");
    testing::expect_refused(stability({"--json", "/no/such/folder/x.json"}), "/no/such/folder");
}

TEST(StabilityCommand, RefusesRangesThatCannotBe) {
    testing::expect_refused(stability({"--vary", "gain"}), "kp, kd, lambda");
    testing::expect_refused(stability({"--vary", "kp", "--from", "10", "--to", "1"}),
                            "the first must be below");
    testing::expect_refused(stability({"--vary", "kp", "--from", "1", "--to", "1"}),
                            "the first must be below");
    testing::expect_refused(stability({"--vary", "T", "--from", "0"}), "1e-06 to 1");
    testing::expect_refused(stability({"--vary", "kp", "--to", "1e9"}), "0 to 10000");
    testing::expect_refused(stability({"--vary", "kp", "--from", "nan"}), "kp");
    testing::expect_refused(stability({"--vary", "d", "--to", "8.5"}), "0 to 8 periods");
    testing::expect_refused(stability({"--from", "1"}), "--vary");
}

TEST(StabilityCommand, RefusesMapsThatCannotBe) {
    testing::expect_refused(stability({"--map", "kp,kp", "--out", "x.svg"}), "twice");
    testing::expect_refused(stability({"--map", "kp", "--out", "x.svg"}), "--map");
    testing::expect_refused(stability({"--map", "kp,gain", "--out", "x.svg"}), "gain");
    testing::expect_refused(stability({"--map", "kp=5,kd", "--out", "x.svg"}), "NAME=FROM:TO");
    testing::expect_refused(stability({"--map", "kp=5:1,kd", "--out", "x.svg"}), "below");
    testing::expect_refused(stability({"--map", "kp=1:2x,kd", "--out", "x.svg"}), "NAME=FROM:TO");
    testing::expect_refused(stability({"--map", "kp,kd"}), "--out");
    testing::expect_refused(stability({"--map", "kp,kd", "--out", "x.png"}), ".svg");
    testing::expect_refused(stability({"--map", "kp,kd", "--out", "/no/such/folder/x.svg"}),
                            "/no/such/folder");
    testing::expect_refused(stability({"--map", "kp,kd", "--out", "x.svg", "--steps", "1"}),
                            "--steps");
    testing::expect_refused(stability({"--map", "kp,kd", "--out", "x.svg", "--steps", "401"}),
                            "--steps");
}

} // namespace
} // namespace springdrive::app

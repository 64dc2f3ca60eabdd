// Covers app/commands/stability_{command,options}.cpp, from outside.
#include "engine/lab/limits/stability_limits.h"
#include "tests/support/csv.h"
#include "tests/support/program.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <functional>
#include <numbers>
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

TEST(StabilityCommand, ExitsByTheAnswerAndSaysWhyPredictionAndSimulationMayDiffer) {
    struct Case {
        const char *kp;
        int status;
        std::vector<const char *> says;
    };
    for (const Case &one :
         {Case{"6", 0, {"predicted  stable", "simulated  stable"}},
          Case{"60", 3, {"predicted  UNSTABLE", "simulated  UNSTABLE"}},
          // Just below the predicted limit, where encoder counts sustain a vibration.
          Case{"29.5", 3, {"predicted  stable", "simulated  UNSTABLE", "they differ because"}}}) {
        const testing::Ending ending = stability({"--kp", one.kp});
        EXPECT_EQ(ending.exit_status, one.status) << one.kp;
        EXPECT_EQ(ending.error, "");
        for (const char *part : one.says) {
            EXPECT_NE(ending.out.find(part), std::string::npos) << part << " in\n" << ending.out;
        }
    }
}

TEST(StabilityCommand, FindsTheLimitsOfOneParameter) {
    const loops::StabilityParameter &kp = *loops::stability_parameter_named("kp");
    const std::vector<limits::StabilityLimit> truth =
        limits::predicted_limits(testing::firm(), kp, {1.0, 100.0});
    ASSERT_EQ(truth.size(), 1U);
    const std::vector<std::string> options{"--vary", "kp", "--from", "1", "--to", "100"};
    const Json said = json_of(options);
    EXPECT_TRUE(said["stable"]);
    EXPECT_EQ(said["vary"], "kp");
    EXPECT_EQ(said["unit"], "V/rad");
    EXPECT_EQ(said["from"], 1.0);
    EXPECT_EQ(said["to"], 100.0);
    EXPECT_TRUE(said["throughout"].is_null());
    ASSERT_EQ(said["limits"].size(), 1U);
    const Json &limit = said["limits"][0];
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
         {Range{{"--vary", "kp", "--from", "60", "--to", "70"}, "unstable", 0},
          Range{{"--vary", "kp", "--from", "1", "--to", "2", "--kp", "60"}, "stable", 3},
          Range{{"--vary", "dR", "--from", "-2", "--to", "-1"}, "unstable", 0}}) {
        const testing::Ending ending = stability(range.options);
        EXPECT_EQ(ending.exit_status, range.exit_status);
        EXPECT_NE(
            ending.out.find("no limit within it, predicted " + range.throughout + " throughout\n"),
            std::string::npos)
            << ending.out;
        const Json said = json_of(range.options);
        EXPECT_TRUE(said["limits"].empty());
        EXPECT_EQ(said["throughout"], range.throughout);
    }
}

TEST(StabilityCommand, KnowsEveryLoopThatCanBeTyped) {
    struct Case {
        std::vector<std::string> options;
        std::function<void(loops::StabilityCase &)> change;
    };
    for (const Case &one : {
             Case{{}, [](loops::StabilityCase &) {}},
             Case{{"--motors", "3"},
                  [](auto &which) { which.freedom = loops::Freedom::three_motors; }},
             Case{{"--motors", "3", "--kinematics", "inverse", "--q", "10,-5,30"},
                  [](auto &which) {
                      which.freedom = loops::Freedom::three_motors;
                      which.tuning.map = control::MotionMap::inverse;
                      which.q_rad = Vector3(10.0, -5.0, 30.0) * std::numbers::pi / 180.0;
                  }},
             Case{{"--no-hand", "--servo-hz", "2500", "--delay", "1.25"},
                  [](auto &which) {
                      which.hands = {loops::no_hand()};
                      which.period_s = 1.0 / 2500.0;
                      which.delay_periods = 1.25;
                  }},
             Case{{"--drive", "current", "--wall-stiffness", "500", "--wall-damping", "1.5"},
                  [](auto &which) {
                      which.drive = device::AmplifierKind::current_drive;
                      which.wall = {500.0, 1.5};
                  }},
             Case{{"--dR", "-0.05"}, [](auto &which) { which.net_resistance_Ohm = -0.05; }},
             Case{{"--inertia", "3e-5", "--damping", "1e-4"},
                  [](auto &which) {
                      which.rotor = device::RotorLoad{3e-5, 1e-4, 0.0};
                  }},
         }) {
        loops::StabilityCase which = testing::firm();
        one.change(which);
        EXPECT_EQ(json_of(one.options)["predicted"]["largest_eigenvalue"].get<double>(),
                  loops::worst_member(which).eigenvalue)
            << (one.options.empty() ? "" : one.options.front());
    }
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

TEST(StabilityCommand, DrawsAMap) {
    const std::filesystem::path folder = testing::fresh_folder("stability_map");
    const testing::Ending ending = stability(
        {"--map", "kp=1:100,dR=0.1:2", "--steps", "4", "--no-hand", "--out", folder / "map.svg"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    const std::string svg = testing::contents_of(folder / "map.svg");
    EXPECT_NE(svg.find("<svg"), std::string::npos);
    EXPECT_NE(svg.find("</svg>"), std::string::npos);
    const std::string csv = testing::contents_of(folder / "map.csv");
    EXPECT_EQ(csv.substr(0, csv.find('\n')),
              "kp,dR,largest_eigenvalue,stable_simulated,remaining_m_per_s");
    const std::vector<std::vector<double>> rows = testing::parsed_numbers(csv);
    ASSERT_EQ(rows.size(), 20U); // each of the grid's four rows ends with an empty line
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::vector<double> &row = rows[i];
        ASSERT_EQ(row.size(), i % 5 == 4 ? 1U : 5U) << i;
        if (i % 5 == 4) {
            continue;
        }
        loops::StabilityCase which = testing::firm();
        which.hands = {loops::no_hand()};
        which.tuning.K_P_V_per_rad = row[0];
        which.net_resistance_Ohm = row[1];
        EXPECT_NEAR(row[2], loops::worst_member(which).eigenvalue, 1e-6) << i;
    }
}

} // namespace
} // namespace springdrive::app

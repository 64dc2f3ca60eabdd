// Covers app/commands/{baseline,tune,stiffness}_command.cpp, from outside.
#include "app/commands/command.h"
#include "engine/control/tuning_file.h"
#include "engine/lab/limits/auto_tune.h"
#include "engine/lab/limits/stability_limits.h"
#include "engine/lab/loops/passivity.h"
#include "tests/support/csv.h"
#include "tests/support/program.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <numbers>
#include <span>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

testing::Ending run_tuning(const char *command, std::vector<std::string> options) {
    options.insert(options.begin(), command);
    return testing::run_program(options);
}

/// At 250 Hz, where tuning is fast: three drives, with the count force of the quiet one not above
/// that of the spring drive.
TEST(BaselineCommand, ComparesThreeDrives) {
    const testing::Ending ending =
        run_tuning("baseline", {"--servo-hz", "250", "--delay", "1", "--dR", "0.8", "--csv", "-"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    const auto lines = testing::parsed_csv(ending.out);
    const std::vector<std::string> &names = lines.front();
    std::map<std::string, std::map<std::string, std::string>> drives;
    for (const std::vector<std::string> &values : std::span(lines).subspan(1)) {
        ASSERT_EQ(values.size(), names.size());
        for (std::size_t i = 0; i < names.size(); ++i) {
            drives[values[3]][names[i]] = values[i];
        }
    }
    ASSERT_EQ(drives.size(), 3U);
    EXPECT_EQ(drives.at("spring").at("delay_periods"), "1");
    const auto value = [&](const std::string &drive, const std::string &name) {
        return std::stod(drives.at(drive).at(name));
    };
    // (14) is caused by the inductance, which a current drive does not use.
    EXPECT_GT(value("spring", "K_HF_N_per_m"), 1e4);
    EXPECT_EQ(value("current", "K_HF_N_per_m"), 0.0);
    // The static stiffness of a wall is that to which it was tuned.
    EXPECT_NEAR(value("current", "K_DC_N_per_m"), value("current", "wall_K_N_per_m"),
                1e-4 * value("current", "wall_K_N_per_m"));
    EXPECT_LE(value("current, as quiet", "count_N"), value("spring", "count_N") * (1.0 + 1e-5));
    EXPECT_LE(value("current, as quiet", "K_DC_N_per_m"), value("current", "K_DC_N_per_m") * 1.01);
    // Free space: the lag adds mass with the spring drive, and none with the current drive.
    EXPECT_GT(value("spring", "apparent_mass_kg"), value("current", "apparent_mass_kg"));
}

/// Both outputs of the tuning, and its use by every command. The whole search takes seconds.
TEST(TuneCommand, WritesATuningThatIsStable) {
    const std::filesystem::path file = testing::fresh_folder("tune") / "found.toml";
    std::vector<std::string> options{"--servo-hz", "500", "--dR", "0.8", "--margin", "1.5"};
    const testing::Ending to_standard_output = run_tuning("tune", options);
    options.insert(options.end(), {"--out", file});
    const testing::Ending told = run_tuning("tune", options);
    ASSERT_EQ(told.exit_status, 0) << told.error;
    EXPECT_EQ(told.out.substr(0, 4), "K_P ") << told.out;
    EXPECT_NE(told.out.find("margins: "), std::string::npos) << told.out;
    EXPECT_NE(told.out.find("coupling passive"), std::string::npos) << told.out;
    EXPECT_EQ(to_standard_output.out, testing::contents_of(file))
        << "the report is on a separate stream";
    EXPECT_EQ(to_standard_output.error.substr(0, 4), "K_P ") << to_standard_output.error;

    const control::TuningFile found = control::read_whole_tuning_file(file);
    EXPECT_EQ(control::validate(found.tuning), "");
    EXPECT_EQ(found.tuning.dR_Ohm, 0.8);
    ASSERT_TRUE(found.margins);
    EXPECT_NEAR(found.margins->servo_hz, 500.0, 1e-9);
    EXPECT_GE(found.margins->gain, 1.5 * (1.0 - 1e-3));
    const testing::Ending stable =
        run_tuning("stability", {"--tuning-file", file, "--servo-hz", "500"});
    EXPECT_EQ(stable.exit_status, 0) << stable.out << stable.error;
    EXPECT_NE(stable.out.find("coupling   passive"), std::string::npos) << stable.out;
}

TEST(TuneCommand, SaysByHowManyPerCentCountsHeldItBack) {
    limits::AutoTuned found;
    const auto said = [&found] {
        std::ostringstream text;
        write_tuned(text, found);
        return text.str();
    };
    EXPECT_EQ(said().find(" %"), std::string::npos) << said();
    found.taken_back = 0.07;
    EXPECT_NE(said().find("K_P is 7 % below"), std::string::npos) << said();
    EXPECT_EQ(said().find("end of its range"), std::string::npos) << said();
    found.tuning.K_P_V_per_rad = limits::AutoTuneRequest{}.max_K_P_V_per_rad;
    EXPECT_NE(said().find("end of its range"), std::string::npos) << said();
}

TEST(StiffnessCommand, WritesPureCsvToStandardOutputAndToAFile) {
    const std::filesystem::path file = testing::fresh_folder("stiffness") / "k.csv";
    const testing::Ending ending =
        run_tuning("stiffness", {"--csv", "-", "--points", "9", "--freq-from", "2"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.error, "");
    EXPECT_EQ(ending.out.substr(0, ending.out.find('\n')),
              "freq_hz,analytic_mag,analytic_phase_deg,sampled_mag,sampled_phase_deg,measured_mag,"
              "measured_phase_deg");
    const std::vector<std::vector<double>> rows = testing::parsed_numbers(ending.out);
    ASSERT_EQ(rows.size(), 9U);
    EXPECT_NEAR(rows.front()[0], 2.0, 1e-3);  // a window of 1000 ticks moves it by 1/2000
    EXPECT_NEAR(rows.back()[0], 250.0, 0.13); // a quarter of the default rate
    for (const std::vector<double> &row : rows) {
        ASSERT_EQ(row.size(), 7U);
        EXPECT_NEAR(row[5], row[3], 0.01 * row[3]) << row[0] << " Hz";
        EXPECT_NEAR(row[6], row[4], 1.0) << row[0] << " Hz";
    }
    const testing::Ending to_file =
        run_tuning("stiffness", {"--csv", file, "--points", "9", "--freq-from", "2"});
    EXPECT_EQ(to_file.exit_status, 0) << to_file.error;
    EXPECT_EQ(to_file.out, "");
    EXPECT_EQ(testing::contents_of(file), ending.out);
}

TEST(StiffnessCommand, TellsLevelsCornersAndStability) {
    struct Case {
        std::vector<std::string> options;
        std::vector<const char *> says;
    };
    for (const Case &one :
         {Case{{}, {"0.2808", "2.301", "334.4 Hz", "159.2 Hz", "1458 Hz", " stable"}},
          Case{{"--dR", "0.05", "--kp", "20", "--delay", "2"}, {"UNSTABLE", ", delay 2\n"}},
          Case{{"--delay", "0.25"}, {", delay 0.25\n"}},
          Case{{"--motor", "5,0.001,0.05", "--dR", "1", "--kp", "2"},
               {"K_DC = k_T K_P/dR (13)  0.1 ", "K_HF = k_T²/L     (14)  2.5 "}}}) {
        std::vector<std::string> options = one.options;
        options.insert(options.end(), {"--points", "2"});
        const testing::Ending ending = run_tuning("stiffness", options);
        ASSERT_EQ(ending.exit_status, 0) << ending.error;
        for (const char *said : one.says) {
            EXPECT_NE(ending.out.find(said), std::string::npos) << said << " in\n" << ending.out;
        }
    }
}

TEST(StiffnessCommand, HoldsAContact) {
    const testing::Ending table = run_tuning("stiffness", {"--hold", "1", "--seconds", "60"});
    EXPECT_EQ(table.exit_status, 0) << table.error;
    EXPECT_NE(table.out, "");
    const testing::Ending csv =
        run_tuning("stiffness", {"--hold", "1", "--seconds", "60", "--csv", "-"});
    EXPECT_EQ(csv.exit_status, 0) << csv.error;
    EXPECT_EQ(csv.out.substr(0, 6), "time_s") << csv.out;
}

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
        std::vector<std::string> options = range.options;
        options.insert(options.end(), {"--json", "-"});
        const testing::Ending ending = stability(options);
        EXPECT_EQ(ending.exit_status, range.exit_status);
        const Json said = Json::parse(ending.out);
        EXPECT_TRUE(said["limits"].empty());
        EXPECT_EQ(said["throughout"], range.throughout);
        const testing::Ending table = stability(range.options);
        EXPECT_EQ(table.exit_status, range.exit_status);
        EXPECT_NE(
            table.out.find("no limit within it, predicted " + range.throughout + " throughout\n"),
            std::string::npos)
            << table.out;
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

TEST(StabilityCommand, TellsWhetherTheCouplingIsPassive) {
    for (const char *K_P : {"3", "12", "25"}) {
        loops::StabilityCase which = testing::firm();
        which.tuning.K_P_V_per_rad = std::stod(K_P);
        const loops::LeastAtPort passive = loops::passivity(which);
        const bool with_linear_hands = loops::stability_with_linear_hands(which).holds();
        const Json coupling = json_of({"--kp", K_P})["coupling"];
        EXPECT_EQ(coupling["passive"], passive.holds()) << K_P;
        EXPECT_EQ(coupling["stable_with_every_linear_hand"], with_linear_hands) << K_P;
        EXPECT_EQ(coupling["least_absorbed"].get<double>(), passive.value) << K_P;
        EXPECT_EQ(coupling["at_rad_per_s"].get<double>(), passive.omega_rad_per_s) << K_P;
    }
    EXPECT_TRUE(json_of({"--drive", "current"})["coupling"].is_null());
    EXPECT_TRUE(json_of({"--dR", "-0.05"})["coupling"]["least_absorbed"].is_null());
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

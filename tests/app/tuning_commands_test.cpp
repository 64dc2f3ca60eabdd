// Covers app/commands/{baseline,tune,stiffness}_command.cpp, from outside.
#include "app/commands/commands.h"
#include "engine/control/tuning_file.h"
#include "engine/lab/limits/auto_tune.h"
#include "tests/support/csv.h"
#include "tests/support/devices.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <ranges>
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
    for (const std::vector<std::string> &values : lines | std::views::drop(1)) {
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
    EXPECT_EQ(to_standard_output.out, testing::contents_of(file))
        << "the report is on a separate stream";
    EXPECT_EQ(to_standard_output.error.substr(0, 4), "K_P ") << to_standard_output.error;

    const control::TuningFile found = control::read_whole_tuning_file(file);
    EXPECT_EQ(control::validate(found.tuning), "");
    EXPECT_EQ(found.tuning.dR_Ohm, 0.8);
    ASSERT_TRUE(found.margins);
    EXPECT_NEAR(found.margins->servo_hz, 500.0, 1e-9);
    EXPECT_GE(found.margins->gain, 1.5 * (1.0 - 1e-3));
    loops::StabilityCase which;
    which.device = testing::phantom_1_0();
    which.tuning = found.tuning;
    which.period_s = 1.0 / 500.0;
    for (const loops::Freedom freedom : {loops::Freedom::one_motor, loops::Freedom::three_motors}) {
        which.freedom = freedom;
        EXPECT_TRUE(loops::is_stable(which));
    }
    const testing::Ending stable =
        run_tuning("stability", {"--tuning-file", file, "--servo-hz", "500"});
    EXPECT_EQ(stable.exit_status, 0) << stable.out << stable.error;
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

} // namespace
} // namespace springdrive::app

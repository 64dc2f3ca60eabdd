// Covers app/commands/stiffness_command.cpp, from outside.
#include "tests/support/devices.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

testing::Ending stiffness(std::vector<std::string> options) {
    options.insert(options.begin(), "stiffness");
    return testing::run_program(options);
}

using Row = std::vector<double>;

/// The rows of a CSV text below its header.
std::vector<Row> rows_of(const std::string &csv) {
    std::istringstream lines(csv);
    std::string line;
    std::getline(lines, line);
    std::vector<Row> rows;
    while (std::getline(lines, line)) {
        std::istringstream cells(line);
        Row row;
        for (std::string cell; std::getline(cells, cell, ',');) {
            row.push_back(std::stod(cell));
        }
        rows.push_back(row);
    }
    return rows;
}

TEST(StiffnessCommand, WritesPureCsvToStandardOutput) {
    const testing::Ending ending = stiffness({"--csv", "-", "--points", "9", "--freq-from", "2"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.error, "");
    EXPECT_EQ(ending.out.substr(0, ending.out.find('\n')),
              "freq_hz,analytic_mag,analytic_phase_deg,sampled_mag,sampled_phase_deg,measured_mag,"
              "measured_phase_deg");
    const std::vector<Row> rows = rows_of(ending.out);
    ASSERT_EQ(rows.size(), 9U);
    EXPECT_NEAR(rows.front()[0], 2.0, 1e-3);  // a window of 1000 ticks moves it by 1/2000
    EXPECT_NEAR(rows.back()[0], 250.0, 0.13); // a quarter of the default rate
    for (const Row &row : rows) {
        ASSERT_EQ(row.size(), 7U);
        EXPECT_NEAR(row[5], row[3], 0.01 * row[3]) << row[0] << " Hz";
        EXPECT_NEAR(row[6], row[4], 1.0) << row[0] << " Hz";
    }
}

TEST(StiffnessCommand, WritesTheSameToAFile) {
    const std::filesystem::path folder = testing::fresh_folder("stiffness");
    const testing::Ending to_file = stiffness({"--points", "3", "--csv", folder / "k.csv"});
    EXPECT_EQ(to_file.exit_status, 0) << to_file.error;
    EXPECT_EQ(to_file.out, "");
    EXPECT_EQ(testing::contents_of(folder / "k.csv"),
              stiffness({"--points", "3", "--csv", "-"}).out);
    std::filesystem::remove_all(folder);
}

TEST(StiffnessCommand, TellsLevelsCornersAndStability) {
    const testing::Ending ending = stiffness({"--points", "2"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    for (const char *said : {"0.2808", "2.301", "334.4 Hz", "159.2 Hz", "1458 Hz", " stable"}) {
        EXPECT_NE(ending.out.find(said), std::string::npos) << said << " in\n" << ending.out;
    }
    const testing::Ending shaky =
        stiffness({"--points", "2", "--dR", "0.05", "--kp", "20", "--delay", "2"});
    EXPECT_NE(shaky.out.find("UNSTABLE"), std::string::npos) << shaky.out;
    EXPECT_NE(shaky.out.find(", delay 2\n"), std::string::npos) << shaky.out;
    const testing::Ending between = stiffness({"--points", "2", "--delay", "0.25"});
    EXPECT_NE(between.out.find(", delay 0.25\n"), std::string::npos) << between.out;
}

TEST(StiffnessCommand, TakesAnotherMotor) {
    const testing::Ending ending = stiffness({"--motor", "5,0.001,0.05", "--dR", "1", "--kp", "2"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_NE(ending.out.find("K_DC = k_T K_P/dR (13)  0.1 "), std::string::npos) << ending.out;
    EXPECT_NE(ending.out.find("K_HF = k_T²/L     (14)  2.5 "), std::string::npos) << ending.out;
}

TEST(StiffnessCommand, SaysWhatIsWrongInOneLine) {
    testing::expect_refused(stiffness({"--freq-from", "50", "--freq-to", "20"}), "--freq-from");
    testing::expect_refused(stiffness({"--freq-to", "500.1"}), "500");
    testing::expect_refused(stiffness({"--servo-hz", "2000", "--freq-to", "1000.1"}), "1000");
    testing::expect_refused(stiffness({"--freq-from", "0"}), "0.01");
    testing::expect_refused(stiffness({"--freq-from", "nan"}), "--freq-from");
    testing::expect_refused(stiffness({"--freq-to", "nan"}), "--freq-to");
    testing::expect_refused(stiffness({"--freq-to", "inf"}), "--freq-to");
    testing::expect_refused(stiffness({"--points", "1"}), "--points");
    testing::expect_refused(stiffness({"--points", "2.5"}), "--points");
    testing::expect_refused(stiffness({"--servo-hz", "249"}), "250");
    testing::expect_refused(stiffness({"--servo-hz", "nan"}), "250");
    testing::expect_refused(stiffness({"--delay", "-1"}), "--delay");
    testing::expect_refused(stiffness({"--delay", "9"}), "--delay");
    testing::expect_refused(stiffness({"--delay", "8.01"}), "--delay");
    testing::expect_refused(stiffness({"--delay", "nan"}), "--delay");
    testing::expect_refused(stiffness({"--kp", "nan"}), "K_P");
    testing::expect_refused(stiffness({"--dR", "0"}), "--dR");
    testing::expect_refused(stiffness({"--motor", "2.18,-0.000238,0.0234"}), "--motor: L");
    testing::expect_refused(stiffness({"--motor", "0,0.000238,0.0234"}), "--motor: R");
    testing::expect_refused(stiffness({"--motor", "2.18,0.000238,nan"}), "--motor: kT");
    testing::expect_refused(stiffness({"--motor", "2.18,0.000238"}), "--motor");
    testing::expect_refused(stiffness({"--motor", "0.3,0.000238,0.0234"}),
                            "dR is 0.5"); // dR 0.5 of 0.3
    testing::expect_refused(stiffness({"--colour", "blue"}), "--colour");
    testing::expect_refused(stiffness({"--eta", "0.5"}), "--eta"); // does not affect the coupling
    testing::expect_refused(stiffness({"demo"}), "demo");
    testing::expect_refused(stiffness({"--device-file", "none.toml"}), "none.toml");
    testing::expect_refused(stiffness({"--tuning-file", "none.toml"}), "none.toml");
    testing::expect_refused(stiffness({"--csv", "/no/such/folder/k.csv"}), "/no/such/folder/k.csv");
    testing::expect_refused(stiffness({"--csv", "/dev/full"}), "/dev/full");
}

TEST(StiffnessCommand, HoldsAContact) {
    const testing::Ending table = stiffness({"--hold", "1", "--seconds", "60"});
    EXPECT_EQ(table.exit_status, 0) << table.error;
    EXPECT_NE(table.out, "");
    const testing::Ending csv = stiffness({"--hold", "1", "--seconds", "60", "--csv", "-"});
    EXPECT_EQ(csv.exit_status, 0) << csv.error;
    EXPECT_EQ(csv.out.substr(0, 6), "time_s") << csv.out;
    testing::expect_refused(stiffness({"--seconds", "60"}), "--hold");
    testing::expect_refused(stiffness({"--hold", "1", "--points", "5"}), "--points");
    testing::expect_refused(stiffness({"--hold", "nan"}), "nan");
    testing::expect_refused(stiffness({"--hold", "-1"}), "-1");
    testing::expect_refused(stiffness({"--hold", "1", "--seconds", "0"}), "0");
}

} // namespace
} // namespace springdrive::app

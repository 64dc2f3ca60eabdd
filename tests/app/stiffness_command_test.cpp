// Covers app/commands/stiffness_command.cpp and stiffness_report.cpp, from outside.
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

void expect_refused(const std::vector<std::string> &options, const std::string &names) {
    const testing::Ending ending = stiffness(options);
    EXPECT_GT(ending.exit_status, 0) << names;
    EXPECT_EQ(std::count(ending.error.begin(), ending.error.end(), '\n'), 1) << ending.error;
    EXPECT_EQ(ending.error.substr(0, 13), "springdrive: ") << ending.error;
    EXPECT_NE(ending.error.find(names), std::string::npos) << ending.error;
    EXPECT_EQ(ending.out, "");
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
    expect_refused({"--freq-from", "50", "--freq-to", "20"}, "--freq-from");
    expect_refused({"--freq-to", "500.1"}, "500");
    expect_refused({"--servo-hz", "2000", "--freq-to", "1000.1"}, "1000");
    expect_refused({"--freq-from", "0"}, "0.01");
    expect_refused({"--freq-from", "nan"}, "--freq-from");
    expect_refused({"--freq-to", "nan"}, "--freq-to");
    expect_refused({"--freq-to", "inf"}, "--freq-to");
    expect_refused({"--points", "1"}, "--points");
    expect_refused({"--points", "2.5"}, "--points");
    expect_refused({"--servo-hz", "249"}, "250");
    expect_refused({"--servo-hz", "nan"}, "250");
    expect_refused({"--delay", "-1"}, "--delay");
    expect_refused({"--delay", "9"}, "--delay");
    expect_refused({"--delay", "8.01"}, "--delay");
    expect_refused({"--delay", "nan"}, "--delay");
    expect_refused({"--kp", "nan"}, "K_P");
    expect_refused({"--dR", "0"}, "--dR");
    expect_refused({"--motor", "2.18,-0.000238,0.0234"}, "--motor: L");
    expect_refused({"--motor", "0,0.000238,0.0234"}, "--motor: R");
    expect_refused({"--motor", "2.18,0.000238,nan"}, "--motor: kT");
    expect_refused({"--motor", "2.18,0.000238"}, "--motor");
    expect_refused({"--motor", "0.3,0.000238,0.0234"}, "dR is 0.5"); // dR 0.5 of 0.3
    expect_refused({"--colour", "blue"}, "--colour");
    expect_refused({"--eta", "0.5"}, "--eta"); // has no part in the coupling
    expect_refused({"demo"}, "demo");
    expect_refused({"--device-file", "none.toml"}, "none.toml");
    expect_refused({"--tuning-file", "none.toml"}, "none.toml");
    expect_refused({"--csv", "/no/such/folder/k.csv"}, "/no/such/folder/k.csv");
    expect_refused({"--csv", "/dev/full"}, "/dev/full");
}

TEST(StiffnessCommand, HoldsAContact) {
    const testing::Ending table = stiffness({"--hold", "1", "--seconds", "60"});
    EXPECT_EQ(table.exit_status, 0) << table.error;
    EXPECT_NE(table.out, "");
    const testing::Ending csv = stiffness({"--hold", "1", "--seconds", "60", "--csv", "-"});
    EXPECT_EQ(csv.exit_status, 0) << csv.error;
    EXPECT_EQ(csv.out.substr(0, 6), "time_s") << csv.out;
    expect_refused({"--seconds", "60"}, "--hold");
    expect_refused({"--hold", "1", "--points", "5"}, "--points");
    expect_refused({"--hold", "nan"}, "nan");
    expect_refused({"--hold", "-1"}, "-1");
    expect_refused({"--hold", "1", "--seconds", "0"}, "0");
}

} // namespace
} // namespace springdrive::app

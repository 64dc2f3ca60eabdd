// Covers app/commands/sweep_command.cpp, from outside, on an emulated board.
#include "tests/support/files.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

/// Of two points of one motor.
testing::Ending sweep(const std::vector<std::string> &options) {
    std::vector<std::string> all{"device",   "sweep", "--motors",    "2",
                                 "--points", "2",     "--freq-from", "20"};
    all.insert(all.end(), options.begin(), options.end());
    return testing::run_program(all);
}

std::vector<double> cells_of(const std::string &line) {
    std::istringstream cells(line);
    std::vector<double> row;
    for (std::string cell; std::getline(cells, cell, ',');) {
        row.push_back(std::stod(cell));
    }
    return row;
}

TEST(SweepCommand, WritesPureCsvToStandardOutput) {
    const testing::Ending ending = sweep({"--csv", "-", "--tolerance", "2"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    std::istringstream lines(ending.out);
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "motor,freq_hz,measured_mag,measured_phase_deg,deviation_percent,sampled_mag,"
                    "sampled_phase_deg,analytic_mag,analytic_phase_deg,magnitude_error_percent,"
                    "phase_error_deg,delay_periods,excitation_V");
    std::size_t rows = 0;
    while (std::getline(lines, line)) {
        const std::vector<double> row = cells_of(line);
        ASSERT_EQ(row.size(), 13U);
        EXPECT_EQ(row[0], 2.0);
        EXPECT_NEAR(row[2], row[5], 0.02 * row[5]); // the promise of docs/commissioning.md
        EXPECT_NEAR(row[3], row[6], 2.0);
        EXPECT_NEAR(row[9], 100.0 * (row[2] / row[5] - 1.0), 1e-4);
        EXPECT_NEAR(row[11], 0.3125, 0.001); // 12.5 loops of the board
        ++rows;
    }
    EXPECT_EQ(rows, 2U);
}

TEST(SweepCommand, DrawsAChartBesideItsNumbersAndATable) {
    const std::filesystem::path folder = testing::fresh_folder("sweep");
    const testing::Ending ending = sweep({"--svg", folder / "k.svg"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_NE(ending.out.find("motor 2: dR 0."), std::string::npos) << ending.out;
    EXPECT_EQ(testing::contents_of(folder / "k.csv").substr(0, 6), "motor,");
    const std::string svg = testing::contents_of(folder / "k.svg");
    EXPECT_NE(svg.find("</svg>"), std::string::npos);
    EXPECT_NE(svg.find("motor 2, measured"), std::string::npos);
    // Nothing is replaced unasked, and that is known before the device moves.
    testing::expect_refused(sweep({"--svg", folder / "k.svg"}), "k.svg");
    std::filesystem::remove_all(folder);
}

TEST(SweepCommand, ADeviceThatDiffersFailsATolerance) {
    // R is 2 % above the file's where the sweep is: 9 % of dR.
    const testing::Ending ending = sweep({"--without-observer", "--tolerance", "2"});
    EXPECT_EQ(ending.exit_status, 1);
    EXPECT_NE(ending.error.find("differs from the sampled form by more than 2 %"),
              std::string::npos)
        << ending.error;
    EXPECT_EQ(sweep({"--without-observer", "--tolerance", "12"}).exit_status, 0);
}

TEST(SweepCommand, ATripEndsItWithOneLine) {
    const testing::Ending ending = sweep({"--fault", "stop@4"});
    EXPECT_EQ(ending.exit_status, 1);
    EXPECT_NE(ending.error.find("springdrive: the safety monitor ended the sweep, and the device "
                                "brakes: the device's board reports its stop switch"),
              std::string::npos)
        << ending.error;
}

TEST(SweepCommand, RefusesWhatItCannotUse) {
    const auto refused = [](const std::vector<std::string> &options, const std::string &names) {
        std::vector<std::string> all{"device", "sweep"};
        all.insert(all.end(), options.begin(), options.end());
        testing::expect_refused(testing::run_program(all), names);
    };
    refused({"--tip-force", "nan"}, "--tip-force is nan");
    refused({"--tip-force", "9"}, "--tip-force is 9");
    refused({"--motion", "0.006"}, "--motion is 0.006");
    refused({"--freq-to", "251"}, "--freq-to is 251");
    refused({"--freq-from", "20", "--freq-to", "20"}, "--freq-from must be below");
    refused({"--points", "201"}, "--points is 201");
    refused({"--tolerance", "nan"}, "--tolerance is nan");
    refused({"--servo-hz", "249"}, "servo rate is 249");
    refused({"--dR", "nan"}, "--dR");
    refused({"--svg", "k.png"}, "must be a file that ends in .svg");
    refused({"--motors", "4"}, "--motors is 4");
}

} // namespace
} // namespace springdrive::app

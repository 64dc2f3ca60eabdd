// Covers app/commands/{device,sweep,commissioning}_command*.cpp from outside, on emulated
// boards, and what a calibrated device file is good for.
#include "tests/support/csv.h"
#include "tests/support/devices.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

/// Without a board on USB: one that cannot be used is listed, too.
TEST(DeviceCommand, InfoTakesWhatListNames) {
    const testing::Ending list = testing::run_program({"device", "list"});
    EXPECT_EQ(list.exit_status, 0) << list.error;
    std::istringstream lines(list.out);
    int named = 0;
    for (std::string line; std::getline(lines, line);) {
        const std::string device = line.substr(0, line.find(' '));
        if (!device.starts_with("usb:")) {
            ++named;
            const testing::Ending used =
                testing::run_program({"device", "info", "--device", device});
            EXPECT_EQ(used.exit_status, 0) << line << ": " << used.error;
        }
    }
    EXPECT_EQ(named, 2); // the simulated one, and an emulated board
}

testing::Ending calibrate(std::vector<std::string> more) {
    more.insert(more.begin(), {"device", "calibrate"});
    return testing::run_program(more);
}

TEST(Calibrate, ADeviceFileIsOfOneDevice) {
    const std::filesystem::path folder = testing::fresh_folder("calibrate_file");
    const std::string mine = folder / "mine.toml";
    const testing::Ending made =
        calibrate({"--device-seed", "7", "--air-C", "25", "--out", mine, "--dR", "0.4"});
    ASSERT_EQ(made.exit_status, 0) << made.error << made.out;
    for (const char *part : {"sim-1-7", "dR of 0.4 Ohm", "saved as", "gain", "temperature"}) {
        EXPECT_NE(made.out.find(part), std::string::npos) << part << ":\n" << made.out;
    }
    EXPECT_NE(made.error.find("swing the stylus"), std::string::npos) << made.error;
    const std::string text = testing::contents_of(mine);
    EXPECT_NE(text.find("[calibration]"), std::string::npos);

    testing::expect_refused(calibrate({"--device-seed", "7", "--out", mine}), "--force");
    EXPECT_EQ(testing::contents_of(mine), text);
    const testing::Ending again = calibrate(
        {"--device-seed", "8", "--device-file", mine, "--out", mine, "--force"}); // another one
    EXPECT_EQ(again.exit_status, 0) << again.error;
    const std::string other = testing::contents_of(mine);
    EXPECT_EQ(other.find("[calibration]"), other.rfind("[calibration]"));

    const auto record = [&](const char *name, const char *seed) {
        return testing::run_program({"record", folder / name, "--seconds", "2.5", "--scene",
                                     testing::assets() / "scenes/plate.gltf", "--lockstep",
                                     "--device-seed", seed, "--device-file", mine});
    };
    const testing::Ending recorded = record("touch.rec", "8");
    EXPECT_EQ(recorded.exit_status, 0) << recorded.error;
    const testing::Ending replayed = testing::run_program({"replay", folder / "touch.rec"});
    EXPECT_NE(replayed.out.find("equal to the last bit"), std::string::npos) << replayed.out;
    EXPECT_EQ(replayed.out.find("differs"), std::string::npos) << replayed.out;
    const testing::Ending refused = record("no.rec", "7");
    testing::expect_one_line(refused, 1, "sim-1-8");
    testing::expect_one_line(refused, 1, "sim-1-7");
}

TEST(Calibrate, SaysWhereItIsKeptAndWhyItIsNot) {
    const testing::Ending shown = calibrate({"--device-seed", "3", "--to-board"});
    EXPECT_EQ(shown.exit_status, 0) << shown.error << shown.out;
    EXPECT_NE(shown.out.find("stored on the board"), std::string::npos) << shown.out;
    const testing::Ending early = calibrate({"--device-seed", "3", "--motion-seconds", "1"});
    EXPECT_EQ(early.exit_status, 1) << early.out;
    EXPECT_NE(early.out.find("not calibrated: motor"), std::string::npos) << early.out;
}

/// Of two points of one motor.
testing::Ending sweep(const std::vector<std::string> &options) {
    std::vector<std::string> all{"device",   "sweep", "--motors",    "2",
                                 "--points", "2",     "--freq-from", "20"};
    all.insert(all.end(), options.begin(), options.end());
    return testing::run_program(all);
}

TEST(SweepCommand, WritesPureCsvToStandardOutput) {
    const testing::Ending ending = sweep({"--csv", "-", "--tolerance", "2"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.out.substr(0, ending.out.find('\n')),
              "motor,freq_hz,measured_mag,measured_phase_deg,deviation_percent,sampled_mag,"
              "sampled_phase_deg,analytic_mag,analytic_phase_deg,magnitude_error_percent,"
              "phase_error_deg,delay_periods,excitation_V");
    const std::vector<std::vector<double>> rows = testing::parsed_numbers(ending.out);
    ASSERT_EQ(rows.size(), 2U);
    for (const std::vector<double> &row : rows) {
        ASSERT_EQ(row.size(), 13U);
        EXPECT_EQ(row[0], 2.0);
        EXPECT_NEAR(row[2], row[5], 0.02 * row[5]); // the promise of docs/commissioning.md
        EXPECT_NEAR(row[3], row[6], 2.0);
        EXPECT_NEAR(row[9], 100.0 * (row[2] / row[5] - 1.0), 1e-4);
        EXPECT_NEAR(row[11], 0.3125, 0.001); // 12.5 loops of the board
    }
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
}

TEST(SweepCommand, EndsByWhatIsFound) {
    struct Case {
        std::vector<std::string> options;
        int status;
        const char *says;
    };
    for (const Case &one : {
             // R is 2 % above the file's where the sweep is: 9 % of dR.
             Case{{"--without-observer", "--tolerance", "2"}, 1, "sampled form by more than 2 %"},
             Case{{"--without-observer", "--tolerance", "12"}, 0, ""},
             Case{{"--fault", "stop@4"},
                  1,
                  "the device brakes: the device's board reports its stop"},
         }) {
        const testing::Ending ending = sweep(one.options);
        EXPECT_EQ(ending.exit_status, one.status) << one.says;
        EXPECT_NE(ending.error.find(one.says), std::string::npos) << ending.error;
    }
}

} // namespace
} // namespace springdrive::app

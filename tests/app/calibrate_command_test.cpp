// Covers app/commands/calibrate_command.cpp, and what a calibrated device file is good for.
#include "tests/support/devices.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

class Calibrate : public ::testing::Test {
protected:
    void SetUp() override {
        folder =
            testing::fresh_folder(::testing::UnitTest::GetInstance()->current_test_info()->name());
    }

    static testing::Ending calibrate(std::vector<std::string> more) {
        more.insert(more.begin(), {"device", "calibrate"});
        return testing::run_program(more);
    }

    [[nodiscard]] std::vector<std::string> a_record(const std::string &name,
                                                    const std::string &seed) const {
        return {"record",
                (folder / name).string(),
                "--seconds",
                "2.5",
                "--scene",
                (testing::assets() / "scenes/plate.gltf").string(),
                "--lockstep",
                "--device-seed",
                seed,
                "--device-file",
                (folder / "mine.toml").string()};
    }

    std::filesystem::path folder;
};

TEST_F(Calibrate, ADeviceFileIsOfOneDevice) {
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

    const testing::Ending recorded = testing::run_program(a_record("touch.rec", "8"));
    EXPECT_EQ(recorded.exit_status, 0) << recorded.error;
    const testing::Ending replayed = testing::run_program({"replay", folder / "touch.rec"});
    EXPECT_NE(replayed.out.find("equal to the last bit"), std::string::npos) << replayed.out;
    EXPECT_EQ(replayed.out.find("differs"), std::string::npos) << replayed.out;
    const testing::Ending refused = testing::run_program(a_record("no.rec", "7"));
    testing::expect_one_line(refused, 1, "sim-1-8");
    testing::expect_one_line(refused, 1, "sim-1-7");
}

TEST_F(Calibrate, IsToldAllTheSame) {
    const testing::Ending shown =
        calibrate({"--device-seed", "3", "--to-board", "--motion-seconds", "60"});
    EXPECT_EQ(shown.exit_status, 0) << shown.error << shown.out;
    EXPECT_NE(shown.out.find("stored on the board"), std::string::npos) << shown.out;
    const testing::Ending early = calibrate({"--device-seed", "3", "--motion-seconds", "1"});
    EXPECT_EQ(early.exit_status, 1) << early.out;
    EXPECT_NE(early.out.find("not calibrated: motor"), std::string::npos) << early.out;
}

TEST_F(Calibrate, RefusesWhatIsOutOfRange) {
    testing::expect_refused(calibrate({"--air-C", "77"}), "--air-C");
    testing::expect_refused(calibrate({"--dR", "0"}), "--dR");
    testing::expect_refused(calibrate({"--motion-seconds", "0"}), "--motion-seconds");
    testing::expect_refused(calibrate({"--out", folder / "none" / "mine.toml"}), "none");
    const std::string mine = folder / "mine.toml";
    std::ofstream(mine) << testing::contents_of(testing::assets() / "devices/phantom_1_0.toml")
                        << "\n[calibration]\nserial = 7\n";
    testing::expect_refused(calibrate({"--device-file", mine}), "calibration.serial");
}

} // namespace
} // namespace springdrive::app

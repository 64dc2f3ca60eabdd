// Covers app/commands/typed_session.cpp: its errors and warnings, from outside.
#include "engine/control/tuning_file.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

/// Models are cached in a separate folder.
class TypedSession : public ::testing::Test {
protected:
    TypedSession() : cache_(testing::fresh_folder("typed_session_cache")) {
        setenv("XDG_CACHE_HOME", cache_.c_str(), 1);
    }
    ~TypedSession() override { unsetenv("XDG_CACHE_HOME"); }

    [[nodiscard]] bool is_empty() const { return std::filesystem::is_empty(cache_); }

private:
    std::filesystem::path cache_;
};

TEST_F(TypedSession, TheCommandLineRefusesWhatDoesNotGoTogetherInOneLine) {
    const auto expect_refused = [](std::vector<std::string> options, const std::string &names) {
        const std::string file = testing::fresh_folder("refused") / "touch.rec";
        options.insert(options.begin(), {"record", file, "--lockstep", "--seconds", "0.01"});
        const testing::Ending ending = testing::run_program(options);
        EXPECT_GT(ending.exit_status, 0) << names;
        EXPECT_EQ(std::count(ending.error.begin(), ending.error.end(), '\n'), 1) << ending.error;
        EXPECT_NE(ending.error.find(names), std::string::npos) << ending.error;
    };
    expect_refused({"--model", "auto", "--without", "gravity"}, "give one or the other");
    expect_refused({"--plant-model", "full", "--with", "gravity"}, "give one or the other");
    expect_refused({"--cpu", "1023"}, "--cpu 1023: this process may run on processors");
    expect_refused({"--plant-model", "fullest"}, "--plant-model");
    expect_refused({"--step-us", "0.5"}, "--step-us is 0.5; it must be from 1 to 4000");
    expect_refused({"--contact-shape", "simplified_1"}, "--contact-shape simplified_1");
    expect_refused({"--contact-shape", "primitives", "--scene",
                    testing::assets() / "scenes/stepped_block.gltf"},
                   "cannot be touched as 'primitives'");
    expect_refused({"--fault", "stop"}, "give --device emulated");
    expect_refused({"--true-device-file", testing::assets() / "devices/phantom_1_0.toml"},
                   "give --device emulated");
    expect_refused({"--device", "emulated", "--fault", "stopp"}, "nearest name is 'stop'");
    expect_refused({"--device", "emulated", "--step-us", "50"}, "--step-us");
    expect_refused({"--device", "emulated", "--plant-model", "full"}, "--plant-model");
    expect_refused({"--device", "emulated", "--delay", "9"}, "the delay is 9 periods");
    expect_refused({"--device", "emulated:4711"}, "4711");
    expect_refused({"--device", "emulator"}, "must be sim, usb, usb:SERIAL or emulated");
    EXPECT_TRUE(is_empty());
}

TEST_F(TypedSession, AnEmulatedBoardIsTouchedByItsScriptAndItsFaultStopsIt) {
    const std::filesystem::path folder = testing::fresh_folder("emulated_record");
    const auto ending_of = [&](std::vector<std::string> options) {
        options.insert(options.begin(), {"record", folder / "touch.rec", "--force", "--lockstep",
                                         "--seconds", "4", "--device", "emulated", "--at-zero",
                                         "--scene", testing::assets() / "scenes/plate.gltf"});
        return testing::run_program(options);
    };
    const testing::Ending whole = ending_of({"--device-seed", "3", "--without", "gravity"});
    EXPECT_EQ(whole.exit_status, 0) << whole.error;
    const testing::Ending stopped = ending_of({"--fault", "stop@2"});
    EXPECT_EQ(stopped.exit_status, 1);
    EXPECT_NE(stopped.error.find("stop switch"), std::string::npos) << stopped.error;
    std::filesystem::remove_all(folder);
}

/// A tuning file states the rate and the delay for which it was found: a slower rate or a longer
/// delay causes a warning, others do not.
TEST_F(TypedSession, ATuningOfAFasterOrEarlierServoIsWarnedOf) {
    const std::filesystem::path folder = testing::fresh_folder("margins");
    control::TuningFile file;
    file.margins = control::TuningMargins{1000.0, 1.0, 1.5, 2, 0.25, 0.5, "firm", 0.75};
    std::ostringstream text;
    control::write_tuning_file(text, file);
    const std::filesystem::path tuning = folder / "found.toml";
    std::ofstream(tuning) << text.str();
    const auto warning = [&](const char *servo_hz, const char *delay) {
        const testing::Ending ending =
            testing::run_program({"record", folder / (std::string(servo_hz) + "_" + delay + ".rec"),
                                  "--lockstep", "--seconds", "0.01", "--tuning-file", tuning,
                                  "--servo-hz", servo_hz, "--delay", delay});
        EXPECT_EQ(ending.exit_status, 0) << ending.error;
        return ending.error.find("was found for 1000 Hz and a delay of 1") != std::string::npos;
    };
    EXPECT_FALSE(warning("1000", "1"));
    EXPECT_FALSE(warning("2000", "0.5"));
    EXPECT_TRUE(warning("999", "1"));
    EXPECT_TRUE(warning("1000", "1.25"));
    std::filesystem::remove_all(folder);
}

} // namespace
} // namespace springdrive::app

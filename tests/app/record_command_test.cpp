// Covers app/commands/{record,export,replay}_command.cpp with records, and typed_session.cpp's
// warnings, from outside.
#include "engine/control/tuning_file.h"
#include "tests/support/devices.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

class Record : public ::testing::Test {
protected:
    /// In lockstep on the plate: 2500 ticks, of which 1000 touch it.
    std::string make(const std::string &name, std::vector<std::string> more = {}) const {
        more.insert(more.begin(), {"record", folder / name, "--seconds", "2.5", "--scene",
                                   testing::assets() / "scenes/plate.gltf", "--lockstep"});
        const testing::Ending ending = testing::run_program(more);
        EXPECT_EQ(ending.exit_status, 0) << ending.error;
        return folder / name;
    }
    static std::string exported(const std::string &record, const char *columns) {
        return testing::run_program({"export", record, "--csv", "-", "--columns", columns}).out;
    }

    std::filesystem::path folder = testing::fresh_folder("record");
};

TEST_F(Record, IsReplayedToTheLastBitAndExportedInPart) {
    const std::string file = make("touch.rec");
    const testing::Ending same = testing::run_program({"replay", file});
    EXPECT_EQ(same.exit_status, 0) << same.error;
    EXPECT_NE(same.out.find("replayed 2500 ticks"), std::string::npos) << same.out;
    EXPECT_NE(same.out.find("e_W_V                  equal to the last bit"), std::string::npos)
        << same.out;
    EXPECT_EQ(same.out.find("differs"), std::string::npos) << same.out;

    const testing::Ending another =
        testing::run_program({"replay", file, "--kp", "12", "--csv", "-"});
    EXPECT_EQ(another.exit_status, 0) << another.error;
    EXPECT_EQ(std::count(another.out.begin(), another.out.end(), '\n'), 2501);
    EXPECT_NE(another.error.find("e_W_V                  differs in"), std::string::npos)
        << another.error;

    const testing::Ending part =
        testing::run_program({"export", file, "--csv", "-", "--columns", "tick,time_s,e_W*",
                              "--from", "1.0", "--to", "1.009"});
    EXPECT_EQ(part.exit_status, 0) << part.error;
    EXPECT_EQ(part.out.substr(0, part.out.find('\n')), "tick,time_s,e_W1_V,e_W2_V,e_W3_V");
    EXPECT_EQ(std::count(part.out.begin(), part.out.end(), '\n'), 11);
    EXPECT_NE(part.error.find("10 rows of 5 columns"), std::string::npos) << part.error;
    const testing::Ending list = testing::run_program({"export", file, "--list"});
    EXPECT_NE(list.out.find("PHANTOM 1.0"), std::string::npos) << list.out;
    for (const char *format : {"--npy", "--mat"}) {
        const std::string out = folder / (std::string("touch") + format);
        EXPECT_EQ(testing::run_program({"export", file, format, out}).exit_status, 0) << format;
        EXPECT_GT(std::filesystem::file_size(out), 2500U * 8U);
    }

    const std::string before = testing::contents_of(file);
    struct Case {
        std::vector<std::string> words;
        const char *names;
    };
    for (const Case &refused : {
             Case{{"record", file}, "touch.rec"},
             Case{{"export", file}, "--csv"},
             Case{{"export", file, "--csv", "-", "--npy", "x"}, "one of"},
             Case{{"export", file, "--csv", "-", "--columns", "tipp_x_m"}, "tipp_x_m"},
             Case{{"export", file, "--csv", "-", "--from", "2", "--to", "1"}, "--from"},
             Case{{"export", file, "--csv", "/dev/full"}, "/dev/full"},
             Case{{"export", file, "--mat", "/dev/null"}, "/dev/null"},
             Case{{"export", file, "--mat", "-"}, "--mat"},
             Case{{"export", file, "--mat", folder / "no/such.mat"}, "such.mat"},
             Case{{"export", file, "--npy", file}, "is also read"},
             Case{{"export", file, "--mat", folder / "." / "touch.rec"}, "is also read"},
         }) {
        testing::expect_refused(testing::run_program(refused.words), refused.names);
    }
    EXPECT_TRUE(testing::contents_of(file) == before);
}

TEST_F(Record, OfASampledDeviceIsThatOfItsSeed) {
    const std::string drawn = make("drawn.rec", {"--device-seed", "7"});
    const testing::Ending replayed = testing::run_program({"replay", drawn});
    EXPECT_EQ(replayed.out.find("differs"), std::string::npos) << replayed.out;
    const auto currents = [](const std::string &record) { return exported(record, "current*"); };
    EXPECT_EQ(currents(drawn), currents(make("again.rec", {"--device-seed", "7"})));
    EXPECT_NE(currents(drawn), currents(make("other.rec", {"--device-seed", "8"})));
    EXPECT_EQ(currents(make("nominal.rec")),
              currents(make("without.rec", {"--device-seed", "7", "--without",
                                            "motor_tolerances,commutator_phase,current_sensing"})));

    const auto observed = [](const std::string &record) {
        const std::string csv = exported(record, "R_observed*,R_trusted*");
        return csv.substr(csv.rfind('\n', csv.size() - 2) + 1);
    };
    EXPECT_EQ(observed(drawn), "1,1,1,1,1,1\n");
    const std::string unobserved = make("unobserved.rec", {"--without-observer"});
    EXPECT_EQ(observed(unobserved), "0,0,0,1,1,1\n");
    EXPECT_EQ(testing::run_program({"replay", unobserved}).exit_status, 0);
}

TEST_F(Record, ByTheClockIsReplayedToo) {
    const std::string file = folder / "clock.rec";
    const testing::Ending recorded = testing::run_program(
        {"record", file, "--seconds", "1.5", "--servo-hz", "4000", "--json", "-"});
    ASSERT_NE(recorded.out.find("\"jitter\""), std::string::npos) << recorded.error;
    const testing::Ending ending = testing::run_program({"replay", file});
    EXPECT_EQ(ending.exit_status, 0) << ending.out;
}

TEST_F(Record, AStoppedServoIsNoSuccess) {
    std::string device = testing::contents_of(testing::assets() / "devices/phantom_1_0.toml");
    device.replace(device.find("tip_speed_m_per_s = 2.0"), 23, "tip_speed_m_per_s = 0.01");
    std::ofstream(folder / "slow.toml") << device;
    const testing::Ending slow =
        testing::run_program({"record", folder / "stopped.rec", "--seconds", "2.5", "--lockstep",
                              "--device-file", folder / "slow.toml"});
    EXPECT_EQ(slow.exit_status, 1);
    EXPECT_NE(slow.error.find("tip speed"), std::string::npos) << slow.error;
    EXPECT_EQ(testing::run_program({"replay", folder / "stopped.rec"}).exit_status, 0);

    const auto emulated = [&](std::vector<std::string> more) {
        more.insert(more.begin(), {"record", folder / "touch.rec", "--force", "--lockstep",
                                   "--seconds", "4", "--device", "emulated", "--at-zero", "--scene",
                                   testing::assets() / "scenes/plate.gltf"});
        return testing::run_program(more);
    };
    const testing::Ending whole = emulated({"--device-seed", "3", "--without", "gravity"});
    EXPECT_EQ(whole.exit_status, 0) << whole.error;
    const testing::Ending stopped = emulated({"--fault", "stop@2"});
    EXPECT_EQ(stopped.exit_status, 1);
    EXPECT_NE(stopped.error.find("stop switch"), std::string::npos) << stopped.error;
}

/// A tuning file states the rate and the delay for which it was found: a slower rate or a longer
/// delay causes a warning, others do not.
TEST_F(Record, WithATuningOfAFasterOrEarlierServoIsWarnedOf) {
    control::TuningFile file;
    file.margins = control::TuningMargins{1000.0, 1.0, 1.5, 2, 0.25, 0.5, "firm", 0.75};
    std::ostringstream text;
    control::write_tuning_file(text, file);
    std::ofstream(folder / "found.toml") << text.str();
    const auto warning = [&](const char *servo_hz, const char *delay) {
        const testing::Ending ending = testing::run_program(
            {"record", folder / "short.rec", "--force", "--lockstep", "--seconds", "0.01",
             "--tuning-file", folder / "found.toml", "--servo-hz", servo_hz, "--delay", delay});
        EXPECT_EQ(ending.exit_status, 0) << ending.error;
        return ending.error.find("was found for 1000 Hz and a delay of 1") != std::string::npos;
    };
    EXPECT_FALSE(warning("1000", "1"));
    EXPECT_FALSE(warning("2000", "0.5"));
    EXPECT_TRUE(warning("999", "1"));
    EXPECT_TRUE(warning("1000", "1.25"));
}

} // namespace
} // namespace springdrive::app

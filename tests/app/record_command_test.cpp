// Covers app/commands/record_command.cpp, export_command.cpp and replay_command.cpp.
#include "tests/support/devices.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

namespace springdrive::app {
namespace {

void expect_refusal(const std::vector<std::string> &arguments, const std::string &names) {
    const testing::Ending ending = testing::run_program(arguments);
    EXPECT_NE(ending.exit_status, 0) << names;
    EXPECT_EQ(std::count(ending.error.begin(), ending.error.end(), '\n'), 1) << ending.error;
    EXPECT_NE(ending.error.find(names), std::string::npos) << ending.error;
}

class Record : public ::testing::Test {
protected:
    void SetUp() override {
        folder =
            testing::fresh_folder(::testing::UnitTest::GetInstance()->current_test_info()->name());
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    /// 2.5 s in lockstep on the plate: 2500 ticks.
    std::string make(const std::string &name, std::vector<std::string> more = {}) {
        std::vector<std::string> arguments{
            "record",    (folder / name).string(),
            "--seconds", "2.5",
            "--scene",   (testing::assets() / "scenes/plate.gltf").string(),
            "--lockstep"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const testing::Ending ending = testing::run_program(arguments);
        EXPECT_EQ(ending.exit_status, 0) << ending.error;
        return folder / name;
    }

    std::filesystem::path folder;
};

TEST_F(Record, IsReplayedToTheLastBit) {
    const testing::Ending ending = testing::run_program({"replay", make("touch.rec")});
    EXPECT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_NE(ending.out.find("replayed 2500 ticks"), std::string::npos) << ending.out;
    EXPECT_NE(ending.out.find("e_W_V                  equal to the last bit"), std::string::npos)
        << ending.out;
    EXPECT_EQ(ending.out.find("differs"), std::string::npos) << ending.out;
}

TEST_F(Record, OfASampledDeviceIsReplayedToo) {
    const std::string drawn = make("drawn.rec", {"--device-seed", "7"});
    const testing::Ending ending = testing::run_program({"replay", drawn});
    EXPECT_EQ(ending.out.find("differs"), std::string::npos) << ending.out;
    const auto currents = [](const std::string &record) {
        return testing::run_program({"export", record, "--csv", "-", "--columns", "current*"}).out;
    };
    EXPECT_EQ(currents(drawn), currents(make("again.rec", {"--device-seed", "7"})));
    EXPECT_NE(currents(drawn), currents(make("other.rec", {"--device-seed", "8"})));
    EXPECT_EQ(currents(make("nominal.rec")),
              currents(make("without.rec", {"--device-seed", "7", "--without",
                                            "motor_tolerances,commutator_phase,current_sensing"})));
    expect_refusal({"record", folder / "no.rec", "--device-seed", "-3"}, "--device-seed");
}

TEST_F(Record, HoldsWhatIsObservedOfTheWindings) {
    const auto last_row = [](const std::string &record) {
        const std::string csv = testing::run_program({"export", record, "--csv", "-", "--columns",
                                                      "R_observed*,R_trusted*"})
                                    .out;
        return csv.substr(csv.rfind('\n', csv.size() - 2) + 1);
    };
    EXPECT_EQ(last_row(make("observed.rec", {"--device-seed", "7"})), "1,1,1,1,1,1\n");
    const std::string unobserved = make("unobserved.rec", {"--without-observer"});
    EXPECT_EQ(last_row(unobserved), "0,0,0,1,1,1\n");
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

TEST_F(Record, AnotherTuningIsAskedAsAQuestion) {
    const testing::Ending ending =
        testing::run_program({"replay", make("touch.rec"), "--kp", "12", "--csv", "-"});
    EXPECT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(std::count(ending.out.begin(), ending.out.end(), '\n'), 2501);
    EXPECT_NE(ending.error.find("e_W_V                  differs in"), std::string::npos)
        << ending.error;
}

TEST_F(Record, IsExportedInPart) {
    const std::string file = make("touch.rec");
    const testing::Ending ending =
        testing::run_program({"export", file, "--csv", "-", "--columns", "tick,time_s,e_W*",
                              "--from", "1.0", "--to", "1.009"});
    EXPECT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.out.substr(0, ending.out.find('\n')), "tick,time_s,e_W1_V,e_W2_V,e_W3_V");
    EXPECT_EQ(std::count(ending.out.begin(), ending.out.end(), '\n'), 11);
    EXPECT_NE(ending.error.find("10 rows of 5 columns"), std::string::npos) << ending.error;
    const testing::Ending list = testing::run_program({"export", file, "--list"});
    EXPECT_NE(list.out.find("PHANTOM 1.0"), std::string::npos) << list.out;
    for (const char *format : {"--npy", "--mat"}) {
        const std::string out = folder / (std::string("touch") + format);
        EXPECT_EQ(testing::run_program({"export", file, format, out}).exit_status, 0) << format;
        EXPECT_GT(std::filesystem::file_size(out), 2500U * 8U);
    }
}

TEST_F(Record, TwoRunsInLockstepHoldTheSameRows) {
    const auto rows = [this](const std::string &name) {
        return testing::run_program({"export", make(name), "--csv", "-"}).out;
    };
    EXPECT_TRUE(rows("first.rec") == rows("second.rec"));
}

TEST_F(Record, MistakesAreSaidInOneLine) {
    const std::string file = make("touch.rec");
    std::ofstream(folder / "text.rec") << "a shopping list\n";
    expect_refusal({"record", file}, "touch.rec");
    expect_refusal({"record", folder / "no/such.rec"}, "such.rec");
    expect_refusal({"record", folder / "x.rec", "--seconds", "-1"}, "--seconds");
    expect_refusal({"record", folder / "x.rec", "--cpu", "4711"}, "4711");
    expect_refusal({"record", folder / "x.rec", "--late-limit-ms", "0"}, "--late-limit-ms");
    expect_refusal({"record", folder / "x.rec", "--late-limit-ms", "51"}, "50");
    expect_refusal({"record", folder / "x.rec", "--json", folder / "x.rec"}, "x.rec");
    expect_refusal({"record", folder / "x.rec", "--json", folder / "no/x.json"}, "x.json");
    expect_refusal({"record", "-"}, "record");
    EXPECT_FALSE(std::filesystem::exists(folder / "x.rec")); // all detected before the start
    expect_refusal({"replay", folder / "none.rec"}, "none.rec");
    expect_refusal({"replay", folder / "text.rec"}, "text.rec");
    expect_refusal({"export", file}, "--csv");
    expect_refusal({"export", file, "--csv", "-", "--npy", "x"}, "one of");
    expect_refusal({"export", file, "--csv", "-", "--columns", "tipp_x_m"}, "tipp_x_m");
    expect_refusal({"export", file, "--csv", "-", "--from", "2", "--to", "1"}, "--from");
    expect_refusal({"export", file, "--csv", "/dev/full"}, "/dev/full");
    expect_refusal({"export", file, "--mat", "/dev/null"}, "/dev/null");
    expect_refusal({"export", file, "--mat", "-"}, "--mat");
    const std::string before = testing::contents_of(file);
    expect_refusal({"export", file, "--csv", file}, "is also read");
    expect_refusal({"export", file, "--npy", file}, "is also read");
    expect_refusal({"export", file, "--mat", folder / "." / "touch.rec"}, "is also read");
    expect_refusal({"replay", file, "--csv", file}, "is also read");
    EXPECT_TRUE(testing::contents_of(file) == before);
    expect_refusal({"export", file, "--mat", folder / "no/such.mat"}, "such.mat");
}

TEST_F(Record, AStoppedServoIsNoSuccess) {
    // A device with a force limit near zero.
    std::string device = testing::contents_of(testing::assets() / "devices/phantom_1_0.toml");
    device.replace(device.find("tip_speed_m_per_s = 2.0"), 23, "tip_speed_m_per_s = 0.01");
    std::ofstream(folder / "slow.toml") << device;
    const testing::Ending ending =
        testing::run_program({"record", folder / "stopped.rec", "--seconds", "2.5", "--lockstep",
                              "--device-file", folder / "slow.toml"});
    EXPECT_EQ(ending.exit_status, 1);
    EXPECT_NE(ending.error.find("tip speed"), std::string::npos) << ending.error;
    EXPECT_EQ(testing::run_program({"replay", folder / "stopped.rec"}).exit_status, 0);
}

} // namespace
} // namespace springdrive::app

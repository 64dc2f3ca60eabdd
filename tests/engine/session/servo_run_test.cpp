// Covers engine/session/servo_run.cpp and recording.cpp alone.
#include "engine/session/recording.h"

#include "base/input_error.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/record/record_reader.h"
#include "engine/session/servo_run.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>

namespace springdrive::session {
namespace {

const Vector3 kStart_m(0.0, 0.02, 0.0);

struct Rig {
    simulated::SimulatedPhantom device{testing::phantom_1_0(), {}, kStart_m};
    ServoRun run{device, {1000.0, true, std::nullopt}};
};

TEST(ServoRun, InLockstepRunsEveryTickForAnyFrames) {
    Rig rig;
    for (int frame = 0; frame < 600; ++frame) {
        rig.run.advance(1.0 / 60.0);
    }
    EXPECT_EQ(rig.run.latest().tick + 1, 10'000U);
    rig.run.set_rate(2000.0);
    for (int frame = 0; frame < 60; ++frame) {
        rig.run.advance(1.0 / 60.0);
    }
    EXPECT_EQ(rig.run.latest().tick + 1, 12'000U);
    EXPECT_NEAR(rig.run.latest().time_s, 11.0, 1e-3);
}

TEST(ServoRun, AnotherRateReturnsItsFirstTick) {
    Rig rig;
    EXPECT_EQ(rig.run.set_rate(500.0), 0U);
    rig.run.advance(0.1);
    EXPECT_EQ(rig.run.set_rate(1000.0), 50U);
    EXPECT_THROW(rig.run.set_rate(1.0), InputError);
    EXPECT_EQ(rig.run.rate_hz(), 1000.0);
}

TEST(ServoRun, StopsOnlyWhenReleased) {
    Rig rig;
    rig.run.advance(1.5);
    ASSERT_EQ(rig.run.latest().safety.state, servo::SafetyState::running);
    EXPECT_FALSE(rig.run.stop_if_released());
    rig.run.release(true);
    rig.run.advance(0.9);
    EXPECT_EQ(rig.run.latest().safety.state, servo::SafetyState::releasing);
    EXPECT_FALSE(rig.run.stop_if_released());
    rig.run.release(false); // and continues normally
    rig.run.advance(1.1);
    EXPECT_EQ(rig.run.latest().safety.state, servo::SafetyState::running);
    rig.run.release(true);
    rig.run.advance(1.1);
    EXPECT_EQ(rig.run.latest().safety.state, servo::SafetyState::waiting);
    rig.run.advance(1.0); // and does not start again
    EXPECT_EQ(rig.run.latest().safety.state, servo::SafetyState::waiting);
    EXPECT_TRUE(rig.run.stop_if_released());
}

TEST(ServoRun, RestartsOnAnotherDevice) {
    simulated::SimulatedPhantom other(testing::phantom_premium_1_5(), {}, kStart_m);
    Rig rig; // whose end is the last that the other device hears of
    rig.run.emergency_stop();
    rig.run.advance(0.1);
    rig.run.advance(0.1);
    rig.run.let_go_on();
    rig.run.advance(0.1);
    rig.run.stop();
    rig.run.renew(other);
    rig.run.advance(0.05);
    EXPECT_EQ(rig.run.latest().tick, 49U);
    EXPECT_EQ(rig.run.latest().safety.state, servo::SafetyState::waiting);
    EXPECT_EQ(rig.run.statistics().ticks(), 50U);
}

TEST(ServoRun, ContinuesAfterAPauseDespiteAnException) {
    simulated::SimulatedPhantom device(testing::phantom_1_0(), {}, kStart_m);
    ServoRun run(device, {1000.0, false, std::nullopt});
    static_cast<void>(run.start());
    std::uint64_t tick = 0;
    EXPECT_THROW(run.paused([&] {
        tick = run.latest().tick;
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        run.take_in();
        EXPECT_EQ(run.latest().tick, tick); // nothing ticks
        throw std::runtime_error("no");
    }),
                 std::runtime_error);
    while (run.latest().tick < tick + 20) { // or CTest's patience ends
        run.advance(0.0);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

TEST(ServoRun, ASimulatedDeviceSlowsDownStandsStillAndSteps) {
    simulated::SimulatedPhantom device{testing::phantom_1_0(), {}, kStart_m};
    ServoRun run(device, {1000.0, false, std::nullopt});
    static_cast<void>(run.start());
    ASSERT_TRUE(run.can_change_speed());
    while (run.statistics().ticks() == 0) { // or CTest's patience ends
        run.advance(0.0);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    run.set_speed(0.0);
    run.take_in();
    const std::uint64_t stood = run.latest().tick;
    for (int frame = 0; frame < 20; ++frame) {
        run.advance(1.0 / 60.0);
    }
    EXPECT_EQ(run.latest().tick, stood);
    run.step();
    EXPECT_EQ(run.latest().tick, stood + 1);
    run.set_speed(0.1);
    for (int frame = 0; frame < 60; ++frame) {
        run.advance(1.0 / 60.0);
    }
    EXPECT_EQ(run.latest().tick, stood + 1 + 100); // a second at a tenth
    const double time_s = run.latest().time_s;
    run.step(); // only while it stands still
    EXPECT_EQ(run.latest().time_s, time_s);
    run.set_speed(1.0);
    while (run.latest().tick < stood + 200) { // or CTest's patience ends
        run.advance(1.0 / 60.0);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    run.stop();
    EXPECT_EQ(run.lost_samples(), 0U);
}

/// Nobody would notice that the window stands still.
TEST(ServoRun, DrivesNoMotorBeforeTheFirstFrame) {
    simulated::SimulatedPhantom device{testing::phantom_1_0(), {}, kStart_m};
    ServoRun run(device, {});
    static_cast<void>(run.start());
    const auto runs_until = [&](std::uint64_t tick, bool in_frames) {
        while (run.latest().tick < tick) {
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            in_frames ? run.advance(0.0) : run.take_in();
        }
    };
    runs_until(1000, false); // rest is known after a tenth of it
    EXPECT_EQ(run.latest().safety.state, servo::SafetyState::waiting);
    runs_until(1500, true);
    EXPECT_TRUE(servo::lets_pass(run.latest().safety.state));
    run.stop();
}

TEST(ServoRun, InLockstepADeviceIsSlowedDownStandsStillAndIsSteppedToo) {
    Rig rig;
    ASSERT_TRUE(rig.run.can_change_speed());
    rig.run.set_speed(0.5);
    rig.run.advance(0.1);
    EXPECT_EQ(rig.run.latest().tick + 1, 50U);
    rig.run.set_speed(0.0);
    rig.run.advance(0.1);
    EXPECT_EQ(rig.run.latest().tick + 1, 50U);
    rig.run.step();
    EXPECT_EQ(rig.run.latest().tick + 1, 51U);
    rig.run.set_speed(1.0);
    rig.run.advance(0.1);
    EXPECT_EQ(rig.run.latest().tick + 1, 151U);
}

class RecordingTest : public ::testing::Test {
protected:
    RecordingTest() : folder(testing::fresh_folder("recording")) {}
    ~RecordingTest() override { std::filesystem::remove_all(folder); }

    void tick(int ticks) {
        run.advance(1e-3 * ticks);
        recording.pump();
    }
    void go_on_with(simulated::SimulatedPhantom &next) {
        run.stop();
        recording.end_part(R"({"device":"exchanged"})");
        run.renew(next);
    }

    std::filesystem::path folder;
    simulated::SimulatedPhantom phantom{testing::phantom_1_0(), {}, kStart_m};
    simulated::SimulatedPhantom another{testing::phantom_1_0(), {}, kStart_m};
    ServoRun run{phantom, {1000.0, true, std::nullopt}};
    Recording recording{run};
};

std::uint64_t rows_of(const std::filesystem::path &file) {
    std::uint64_t rows = 0;
    for (record::RecordReader reader(file); reader.next();) {
        rows += reader.rows();
    }
    return rows;
}

TEST_F(RecordingTest, CountsAllPartsTogether) {
    tick(10);
    go_on_with(another);
    EXPECT_TRUE(recording.begin_part(record::record_header(1000.0)).empty()); // nothing ran
    EXPECT_TRUE(std::filesystem::is_empty(folder));
    recording.start(folder / "touch.rec", record::record_header(1000.0));
    tick(100);
    go_on_with(phantom);
    EXPECT_EQ(recording.begin_part(record::record_header(1000.0)), folder / "touch-2.rec");
    EXPECT_TRUE(recording.is_running());
    tick(30);
    recording.stop();
    tick(5);
    EXPECT_FALSE(recording.is_running());
    EXPECT_EQ(recording.status().rows, 130U);
    EXPECT_EQ(rows_of(folder / "touch.rec"), 100U);
    EXPECT_EQ(rows_of(folder / "touch-2.rec"), 30U);
    EXPECT_EQ(recording.file(), folder / "touch-2.rec");
    recording.start(folder / "next.rec", record::record_header(1000.0)); // another recording
    tick(7);
    recording.stop();
    EXPECT_EQ(recording.status().rows, 7U);
    EXPECT_EQ(recording.parts().size(), 1U);
}

TEST_F(RecordingTest, APartThatCannotBeCreatedIsReportedAndEndsTheRecording) {
    recording.start(folder / "touch.rec", record::record_header(1000.0));
    tick(10);
    go_on_with(another);
    record::RecordHeader impossible = record::record_header(1000.0);
    std::filesystem::remove_all(folder);
    EXPECT_THROW(recording.begin_part(impossible), InputError);
    EXPECT_FALSE(recording.is_running());
    EXPECT_NE(recording.status().error, "");
    EXPECT_EQ(recording.status().rows, 10U);
}

} // namespace
} // namespace springdrive::session

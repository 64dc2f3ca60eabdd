// Covers engine/session/servo_run.cpp alone.
#include "engine/session/servo_run.h"

#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/record/record_file.h"
#include "engine/record/telemetry_columns.h"
#include "engine/session/telemetry_history.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <set>
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
    void tick(int ticks) {
        run.advance(1e-3 * ticks);
        recording.pump();
    }
    void go_on_with(simulated::SimulatedPhantom &next) {
        run.stop();
        recording.end_part(R"({"device":"exchanged"})");
        run.renew(next);
    }

    std::filesystem::path folder = testing::fresh_folder("recording");
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

using record::ChannelStore;

const device::DeviceDescription kDevice = testing::phantom_1_0();

double newest(const TelemetryHistory &history, std::string_view name) {
    const ChannelStore &store = history.store();
    return store.value(channel_named(name).value(), store.end() - 1);
}

servo::ServoSample touching_sample(const Vector3 &normal, const Vector3 &force_N) {
    servo::ServoSample sample;
    sample.contact.touching = true;
    sample.contact.normal = normal;
    sample.tip_force_N = force_N;
    return sample;
}

TEST(TelemetryHistory, EveryColumnIsAChannelOfItsOwnName) {
    servo::ServoSample sample;
    double number = 1.0;
    record::for_each_column(sample, [&number](std::string_view, std::string_view, auto &column) {
        using Column = std::decay_t<decltype(column)>;
        if constexpr (std::is_same_v<Column, double>) {
            column = number += 0.25; // each another one
        }
    });
    TelemetryHistory history(kDevice.geometry, 1000.0);
    history.add(sample);
    std::set<std::string> names;
    std::size_t index = 0;
    record::for_each_column(
        sample, [&](std::string_view name, std::string_view unit, const auto &column) {
            EXPECT_EQ(channels().at(index).name, name);
            EXPECT_EQ(channels().at(index).unit, unit);
            const double kept = newest(history, name);
            const auto expected = static_cast<double>(column);
            EXPECT_TRUE(kept == expected || (std::isnan(kept) && std::isnan(expected))) << name;
            names.insert(std::string(name));
            ++index;
        });
    EXPECT_EQ(names.size(), index); // no name twice
    for (; index < channels().size(); ++index) {
        EXPECT_TRUE(names.insert(channels()[index].name).second);
        EXPECT_FALSE(channels()[index].about.empty());
    }
    EXPECT_FALSE(channel_named("no_such_channel").has_value());
}

TEST(TelemetryHistory, ForcesAreSplitInTheLinksPlane) {
    for (const double base_rad : {-0.7, 0.0, 0.4}) {
        const Vector3 outward(std::sin(base_rad), 0.0, std::cos(base_rad));
        servo::ServoSample sample = touching_sample(-outward, 3.0 * outward + Vector3(0, 4.0, 0));
        const Vector3 q_rad(base_rad, 0.1, -0.2);
        sample.theta_rad = kDevice.geometry.transmission_ratio.cwiseProduct(q_rad);
        TelemetryHistory history(kDevice.geometry, 1000.0);
        history.add(sample);
        EXPECT_NEAR(newest(history, "force_outward_N"), 3.0, 1e-12);
        EXPECT_NEAR(newest(history, "force_up_N"), 4.0, 1e-12);
        EXPECT_NEAR(newest(history, "force_N"), 5.0, 1e-12);
        EXPECT_NEAR(std::abs(newest(history, "normal_direction_rad")), std::numbers::pi, 1e-12);
        // Outwards is where the tip goes when the links stretch.
        Vector3 stretched = q_rad;
        stretched.z() += 1e-6;
        const Vector3 step_m = device::tip_position_m(kDevice.geometry, stretched) -
                               device::tip_position_m(kDevice.geometry, q_rad);
        EXPECT_GT(step_m.dot(outward), 0.0);
        EXPECT_NEAR(step_m.dot(outward.cross(Vector3(0, 1, 0))), 0.0, 1e-15);
    }
}

TEST(TelemetryHistory, TheMeasuredErrorBelongsToTheMapInUse) {
    constexpr double kOff_rad = 0.3;
    const Vector3 force_N(2.0 * std::sin(kOff_rad), 2.0 * std::cos(kOff_rad), 0.0);
    servo::ServoSample sample = touching_sample(Vector3(0, 1, 0), force_N);
    for (const control::MotionMap map :
         {control::MotionMap::inverse, control::MotionMap::transpose}) {
        TelemetryHistory history(kDevice.geometry, 1000.0);
        sample.tuning.map = map;
        for (int tick = 0; tick < 200; ++tick) {
            history.add(sample);
        }
        const bool transposes = map == control::MotionMap::transpose;
        EXPECT_NEAR(newest(history, transposes ? "transpose_measured_rad" : "inverse_measured_rad"),
                    kOff_rad, 1e-12);
        EXPECT_TRUE(std::isnan(
            newest(history, transposes ? "inverse_measured_rad" : "transpose_measured_rad")));
    }
}

TEST(TelemetryHistory, AForceAbove30HzIsFiltered) {
    constexpr double kRate_hz = 1000.0;
    constexpr double kForce_Hz = 120.0;
    TelemetryHistory history(kDevice.geometry, kRate_hz);
    double greatest_rad = 0.0;
    for (int tick = 0; tick < 2000; ++tick) {
        const double side_N = std::sin(2.0 * std::numbers::pi * kForce_Hz * tick / kRate_hz);
        servo::ServoSample sample = touching_sample(Vector3(0, 1, 0), Vector3(side_N, 1.0, 0.0));
        sample.tuning.map = control::MotionMap::transpose;
        history.add(sample);
        greatest_rad =
            tick < 1000 ? 0.0 : std::max(greatest_rad, newest(history, "transpose_measured_rad"));
    }
    // |1/(1 + jω/ω_c)| at four times the cutoff, with the sampled filter's a = e^(−ω_c T):
    // (1 − a)/|1 − a e^(−jωT)|.
    const double a = std::exp(-2.0 * std::numbers::pi * 30.0 / kRate_hz);
    const double phase = 2.0 * std::numbers::pi * kForce_Hz / kRate_hz;
    const double gain = (1.0 - a) / std::hypot(1.0 - a * std::cos(phase), a * std::sin(phase));
    EXPECT_NEAR(greatest_rad, std::atan(gain),
                0.01); // ticks miss the peak by up to 1 − cos(phase/2)
    EXPECT_LT(greatest_rad, 0.3);
}

TEST(TelemetryHistory, KeepsEveryTickOfARunThroughChangesOfRateAndDevice) {
    simulated::SimulatedPhantom first(kDevice, {}, Vector3(0.0, 0.02, 0.0));
    simulated::SimulatedPhantom second(kDevice, {}, Vector3(0.0, 0.02, 0.0));
    ServoRun run(first, {1000.0, true, std::nullopt});
    run.advance(0.5);
    run.set_rate(4000.0);
    run.advance(0.5);
    run.stop();
    second.set_period(run.period_s());
    run.renew(second);
    run.advance(0.5);
    const ChannelStore &store = run.history().store();
    EXPECT_EQ(store.end(), 500U + 2000U + 2000U);
    for (std::uint64_t row = 1; row < store.end(); ++row) {
        const double step_s = store.time_s(row) - store.time_s(row - 1);
        ASSERT_NEAR(step_s, row < 500 ? 1e-3 : 0.25e-3, 1e-9) << row;
    }
}

} // namespace
} // namespace springdrive::session

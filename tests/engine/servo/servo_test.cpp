// Covers engine/servo/servo.cpp: the thread, its clock and its end.
#include "engine/servo/servo.h"

#include "base/input_error.h"
#include "device/core/forwarding_device.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/record/telemetry_columns.h"
#include "tests/support/devices.h"
#include "tests/support/own_clock_device.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace springdrive::servo {
namespace {

const Vector3 kStart_m(0.0, 0.02, 0.0);

/// A simulated device that stores the last command.
class RecordingDevice final : public device::ForwardingDevice {
public:
    RecordingDevice()
        : device::ForwardingDevice(std::make_unique<simulated::SimulatedPhantom>(
              testing::phantom_1_0(), simulated::SimulationOptions{}, kStart_m)) {}

    void write(const device::DeviceCommand &command) noexcept override {
        last_command = command;
        ++commands;
        device::ForwardingDevice::write(command);
    }

    device::DeviceCommand last_command;
    int commands = 0;
};

/// All columns of a sample, as bytes.
std::string bytes_of(const ServoSample &sample) {
    std::string bytes;
    record::for_each_column(sample,
                            [&bytes](std::string_view, std::string_view, const auto &value) {
                                bytes.append(reinterpret_cast<const char *>(&value), sizeof value);
                            });
    return bytes;
}

std::vector<std::string> rows_of(Servo &servo) {
    std::vector<std::string> rows;
    servo.drain([&rows](const ServoSample &sample) { rows.push_back(bytes_of(sample)); });
    return rows;
}

TEST(Servo, SendsTheSafeStateLast) {
    RecordingDevice device;
    {
        Servo servo(device, 1000.0);
        servo.publish({});
        servo.advance(1200);
        ASSERT_GT(device.last_command.cancelled_resistance_Ohm.minCoeff(), 1.0); // R̂ is up
        ASSERT_EQ(device.commands, 1200);
    }
    EXPECT_EQ(device.commands, 1201);
    EXPECT_EQ(device.last_command.e_W_V, Vector3::Zero());
    EXPECT_EQ(device.last_command.cancelled_resistance_Ohm, Vector3::Zero());
}

TEST(Servo, SendsTheSafeStateLastFromItsThreadToo) {
    RecordingDevice device;
    {
        Servo servo(device, 1000.0);
        servo.start();
        for (std::uint64_t ticks = 0; ticks < 1300;) {
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
            servo.drain([&ticks](const ServoSample &) { ++ticks; });
        }
        servo.stop();
        servo.stop(); // harmless
    }
    EXPECT_GE(device.commands, 1301);
    EXPECT_EQ(device.last_command.e_W_V, Vector3::Zero());
    EXPECT_EQ(device.last_command.cancelled_resistance_Ohm, Vector3::Zero());
}

TEST(Servo, LockstepIsReproducibleBitForBit) {
    const auto run = [] {
        simulated::SimulationOptions options;
        options.path.emplace(std::vector<simulated::HandPath::Point>{
            {1.2, kStart_m}, {1.7, Vector3(0.0, -0.01, 0.0)}, {2.2, Vector3(0.02, -0.01, 0.01)}});
        simulated::SimulatedPhantom device(testing::phantom_1_0(), options, kStart_m);
        const contact::HapticSurface mesh(
            testing::box_soup(Vector3(-0.05, -0.02, -0.05), Vector3(0.05, 0.0, 0.05)));
        ServoInputs inputs;
        inputs.surface = &mesh;
        Servo servo(device, 1000.0);
        servo.publish(inputs);
        servo.advance(2400);
        return rows_of(servo);
    };
    const std::vector<std::string> first = run();
    EXPECT_EQ(first.size(), 2400U);
    EXPECT_EQ(first, run());
}

TEST(Servo, EveryTickGivesOneSampleInOrder) {
    RecordingDevice device;
    Servo servo(device, 2000.0);
    servo.start();
    std::uint64_t next = 0;
    while (next < 1000) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        servo.drain([&next](const ServoSample &sample) {
            EXPECT_EQ(sample.tick, next);
            ++next;
        });
    }
    servo.stop();
    EXPECT_EQ(servo.lost_samples(), 0U);
}

TEST(Servo, CountsLostSamples) {
    RecordingDevice device;
    Servo servo(device, 1000.0);
    servo.advance(16'384 + 50);
    EXPECT_EQ(servo.lost_samples(), 50U);
    EXPECT_EQ(rows_of(servo).size(), 16'384U);
}

TEST(Servo, TuningFromAnotherThreadArrivesIntact) {
    RecordingDevice device;
    Servo servo(device, 5000.0);
    servo.start();
    // Consistent sets of inputs: the servo must report one of them.
    ServoInputs inputs;
    int seen = 0;
    for (int i = 0; seen < 1000; ++i) { // as long as it takes
        const bool even = i % 2 == 0;
        inputs.tuning.eta = even ? 0.25 : 0.75;
        inputs.tuning.map = even ? control::MotionMap::inverse : control::MotionMap::transpose;
        inputs.scene_id = even ? 2 : 3;
        servo.publish(inputs);
        servo.drain([&seen](const ServoSample &sample) {
            if (sample.scene_id != 0) {
                ++seen;
                EXPECT_EQ(sample.tuning.map == control::MotionMap::inverse, sample.scene_id == 2);
            }
        });
    }
    servo.stop();
}

/// Simulates a host that blocks the servo once, in a given tick.
class StalledHost final : public device::ForwardingDevice {
public:
    StalledHost(device::HapticDevice &device, std::chrono::milliseconds stall, int at_tick)
        : device::ForwardingDevice(device), stall_(stall), at_tick_(at_tick) {}

    [[nodiscard]] device::Measurement read() noexcept override {
        if (++ticks_ == at_tick_) {
            std::this_thread::sleep_for(stall_);
        }
        return device::ForwardingDevice::read();
    }

private:
    std::chrono::milliseconds stall_;
    int at_tick_;
    int ticks_ = 0;
};

constexpr int kStalledTick = 1500;
constexpr std::chrono::milliseconds kStall{300};

/// Runs until some ticks after the stall, or a trip.
std::vector<ServoSample> through_a_stall(device::HapticDevice &device) {
    StalledHost host(device, kStall, kStalledTick);
    Servo servo(host, 1000.0);
    servo.publish({});
    servo.start();
    std::vector<ServoSample> samples;
    while (samples.size() < kStalledTick + 200 &&
           (samples.empty() || samples.back().safety.state != SafetyState::tripped)) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        servo.drain([&samples](const ServoSample &sample) { samples.push_back(sample); });
    }
    servo.stop();
    return samples;
}

TEST(Servo, ASimulatedDeviceWaitsForAStalledHost) {
    simulated::SimulatedPhantom device(testing::phantom_1_0(), {}, kStart_m);
    const std::vector<ServoSample> samples = through_a_stall(device);
    std::uint64_t missed = 0;
    for (const ServoSample &sample : samples) {
        EXPECT_NE(sample.safety.state, SafetyState::tripped) << description(sample.safety);
        EXPECT_EQ(sample.missed_periods, 0U);
        EXPECT_DOUBLE_EQ(sample.since_last_s, 1e-3);
        EXPECT_NEAR(sample.measured_s, (static_cast<double>(sample.tick) + 1.0) * 1e-3, 1e-9);
        missed += sample.missed_deadlines;
    }
    EXPECT_GE(missed, 290U); // counted nevertheless
    EXPECT_EQ(samples.back().safety.state, SafetyState::running);
}

TEST(Servo, ADeviceWithItsOwnClockDoesNotWait) {
    simulated::SimulatedPhantom device(testing::phantom_1_0(), {}, kStart_m);
    testing::OwnClockDevice hardware(device, 1e-3);
    const std::vector<ServoSample> samples = through_a_stall(hardware);
    const auto trip = std::find_if(samples.begin(), samples.end(), [](const ServoSample &sample) {
        return sample.safety.state == SafetyState::tripped;
    });
    ASSERT_NE(trip, samples.end());
    EXPECT_EQ(trip->safety.cause, TripCause::missed_deadlines);
    EXPECT_TRUE(trip->command.e_W_V.isZero(0.0));
    // In the first tick that is late by more than the limit, unless a busy host made an earlier one
    // late.
    EXPECT_GT(trip->missed_in_a_row, 50U);
    EXPECT_LE(trip->tick, static_cast<std::uint64_t>(kStalledTick));
}

/// Sends heartbeats for a while, pauses for longer than the monitor tolerates, then sends them
/// again.
std::vector<ServoSample> through_a_silence(device::HapticDevice &device) {
    Servo servo(device, 1000.0);
    ServoInputs inputs;
    inputs.limits.window_silence_s = 0.2;
    servo.start();
    std::vector<ServoSample> samples;
    const auto frame = [&](bool beats) {
        inputs.heartbeat += beats ? 1U : 0U;
        servo.publish(inputs);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        servo.drain([&samples](const ServoSample &sample) { samples.push_back(sample); });
    };
    const auto frames = [&](int count, bool beat) {
        for (int i = 0; i < count; ++i) {
            frame(beat);
        }
    };
    frames(20, true);
    frames(100, false);
    frames(20, true);
    servo.stop();
    return samples;
}

TEST(Servo, ASimulatedDeviceWaitsForASilentWindow) {
    simulated::SimulatedPhantom device(testing::phantom_1_0(), {}, kStart_m);
    const std::vector<ServoSample> samples = through_a_silence(device);
    std::uint64_t missed = 0;
    for (const ServoSample &sample : samples) {
        EXPECT_NE(sample.safety.state, SafetyState::tripped) << description(sample.safety);
        missed += sample.missed_deadlines;
    }
    EXPECT_GE(missed, 300U); // the half second of silence minus 0.1 s, plus those of a busy host
}

TEST(Servo, AnInvalidLimitPausesNoDevice) {
    for (const double silence_s : {-1.0, 0.0, static_cast<double>(NAN)}) {
        simulated::SimulatedPhantom device(testing::phantom_1_0(), {}, kStart_m);
        Servo servo(device, 1000.0);
        ServoInputs inputs;
        inputs.limits.window_silence_s = silence_s;
        inputs.heartbeat = 1; // the only heartbeat, well within the device's own limit
        servo.publish(inputs);
        servo.start();
        std::uint64_t ticks = 0;
        for (int i = 0; i < 2000 && ticks < 20; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            servo.drain([&ticks](const ServoSample &) { ++ticks; });
        }
        EXPECT_GE(ticks, 20U) << silence_s;
        servo.stop();
    }
}

TEST(Servo, AnotherDeviceStopsWhenTheWindowIsSilent) {
    simulated::SimulatedPhantom device(testing::phantom_1_0(), {}, kStart_m);
    testing::OwnClockDevice hardware(device, 1e-3);
    const std::vector<ServoSample> samples = through_a_silence(hardware);
    EXPECT_EQ(samples.back().safety.state, SafetyState::tripped);
    // A busy host may be the first cause; what matters is the stop.
    EXPECT_TRUE(samples.back().safety.cause == TripCause::window_silent ||
                samples.back().safety.cause == TripCause::missed_deadlines);
}

TEST(Servo, AnotherRateContinuesInTheSameState) {
    simulated::SimulatedPhantom device(testing::phantom_1_0(), {}, kStart_m);
    Servo servo(device, 1000.0);
    servo.publish({});
    servo.advance(1500);
    servo.set_rate(4000.0);
    servo.advance(400);
    EXPECT_THROW(servo.set_rate(1.0), InputError);
    EXPECT_EQ(servo.rate_hz(), 4000.0);
    servo.set_rate(500.0);
    servo.advance(50);
    std::vector<ServoSample> samples;
    servo.drain([&samples](const ServoSample &sample) { samples.push_back(sample); });
    ASSERT_EQ(samples.size(), 1950U);
    for (std::size_t i = 1; i < samples.size(); ++i) {
        const double period_s = i < 1500 ? 1e-3 : (i < 1900 ? 0.25e-3 : 2e-3);
        EXPECT_DOUBLE_EQ(samples[i].since_last_s, period_s);
        EXPECT_NEAR(samples[i].measured_s - samples[i - 1].measured_s, period_s, 1e-12);
        EXPECT_NEAR(samples[i].time_s - samples[i - 1].time_s, period_s, 1e-12);
        EXPECT_EQ(samples[i].tick, i);
    }
    EXPECT_EQ(samples.back().safety.state, SafetyState::running);
}

TEST(Servo, AnotherRateOnItsThreadKeepsSamplesAndState) {
    simulated::SimulatedPhantom device(testing::phantom_1_0(), {}, kStart_m);
    Servo servo(device, 1000.0);
    servo.publish({});
    servo.start();
    std::uint64_t next = 0;
    SafetyState state = SafetyState::waiting;
    const auto run_to = [&](std::uint64_t tick) {
        while (next < tick) {
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
            servo.drain([&](const ServoSample &sample) {
                EXPECT_EQ(sample.tick, next++);
                state = sample.safety.state;
            });
        }
    };
    run_to(1300);
    EXPECT_EQ(state, SafetyState::running);
    for (const double rate_hz : {2000.0, 250.0, 1000.0}) {
        servo.set_rate(rate_hz);
        run_to(next + 100);
        EXPECT_EQ(state, SafetyState::running);
    }
    servo.stop();
}

TEST(Servo, RejectsUnsupportedRates) {
    RecordingDevice device;
    for (const double good : {250.0, 10'000.0}) {
        EXPECT_NO_THROW(Servo(device, good));
    }
    for (const double bad : {249.9, 10'000.1, 0.0, -1.0, static_cast<double>(NAN)}) {
        EXPECT_THROW(Servo(device, bad), InputError);
    }
}

} // namespace
} // namespace springdrive::servo

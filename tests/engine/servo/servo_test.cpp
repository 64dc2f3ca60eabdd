// Covers engine/servo/servo.cpp: the thread, its clock and its ends.
#include "engine/servo/servo.h"

#include "base/input_error.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/servo/record/telemetry_columns.h"
#include "tests/support/devices.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace springdrive {
namespace {

const Vector3 kStart_m(0.0, 0.02, 0.0);

/// Passes everything on to a simulated device and remembers the last command.
class Witness final : public HapticDevice {
public:
    [[nodiscard]] const DeviceDescription &description() const override {
        return device_.description();
    }
    [[nodiscard]] double delay_periods() const override { return 0; }
    DeviceState exchange(const DeviceCommand &command) noexcept override {
        last_command = command;
        ++exchanges;
        return device_.exchange(command);
    }

    DeviceCommand last_command;
    int exchanges = 0;

private:
    SimulatedPhantom device_{testing::phantom_1_0(), {}, kStart_m};
};

/// All that a sample tells, as bytes.
std::string bytes_of(const ServoSample &sample) {
    std::string bytes;
    for_each_column(sample, [&bytes](std::string_view, std::string_view, const auto &value) {
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
    Witness device;
    {
        Servo servo(device, 1000.0);
        servo.publish({});
        servo.advance(1200);
        ASSERT_GT(device.last_command.cancelled_resistance_Ohm.minCoeff(), 1.0); // R̂ is up
        ASSERT_EQ(device.exchanges, 1200);
    }
    EXPECT_EQ(device.exchanges, 1201);
    EXPECT_EQ(device.last_command.e_W_V, Vector3::Zero());
    EXPECT_EQ(device.last_command.cancelled_resistance_Ohm, Vector3::Zero());
}

TEST(Servo, SendsTheSafeStateLastFromItsThreadToo) {
    Witness device;
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
    EXPECT_GE(device.exchanges, 1301);
    EXPECT_EQ(device.last_command.e_W_V, Vector3::Zero());
    EXPECT_EQ(device.last_command.cancelled_resistance_Ohm, Vector3::Zero());
}

TEST(Servo, LockstepRepeatsToTheLastBit) {
    const auto run = [] {
        SimulationOptions options;
        options.path.emplace(std::vector<HandPath::Point>{
            {1.2, kStart_m}, {1.7, Vector3(0.0, -0.01, 0.0)}, {2.2, Vector3(0.02, -0.01, 0.01)}});
        SimulatedPhantom device(testing::phantom_1_0(), options, kStart_m);
        const HapticSurface mesh(
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
    Witness device;
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

TEST(Servo, CountsTheSamplesThatNobodyFetched) {
    Witness device;
    Servo servo(device, 1000.0);
    servo.advance(16'384 + 50);
    EXPECT_EQ(servo.lost_samples(), 50U);
    EXPECT_EQ(rows_of(servo).size(), 16'384U);
}

TEST(Servo, TuningFromAnotherThreadArrivesWhole) {
    Witness device;
    Servo servo(device, 5000.0);
    servo.start();
    // Sets whose parts belong together: what the servo reports must be one of them.
    ServoInputs inputs;
    int seen = 0;
    for (int i = 0; seen < 1000; ++i) { // as long as it takes
        const bool even = i % 2 == 0;
        inputs.tuning.eta = even ? 0.25 : 0.75;
        inputs.tuning.map = even ? MotionMap::inverse : MotionMap::transpose;
        inputs.scene_id = even ? 2 : 3;
        servo.publish(inputs);
        servo.drain([&seen](const ServoSample &sample) {
            if (sample.scene_id != 0) {
                ++seen;
                EXPECT_EQ(sample.tuning.map == MotionMap::inverse, sample.scene_id == 2);
            }
        });
    }
    servo.stop();
}

TEST(Servo, RefusesRatesThatItCannotKeep) {
    Witness device;
    for (const double good : {250.0, 10'000.0}) {
        EXPECT_NO_THROW(Servo(device, good));
    }
    for (const double bad : {249.9, 10'000.1, 0.0, -1.0, static_cast<double>(NAN)}) {
        EXPECT_THROW(Servo(device, bad), InputError);
    }
}

} // namespace
} // namespace springdrive

#include "engine/session/telemetry_history.h"

#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/record/telemetry_columns.h"
#include "engine/session/servo_run.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <string>

namespace springdrive::session {
namespace {

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

// Covers app/demo/shown_values.cpp: the trace, and what is computed for what is switched on.
#include "app/demo/shown_values.h"

#include "device/core/phantom/kinematics.h"
#include "engine/control/haptic_law.h"
#include "engine/session/telemetry_history.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace springdrive::app {
namespace {

/// A tip that circles once in 6 s, with a force that grows by 0.1 N/s.
session::TelemetryHistory circled(double servo_hz, double duration_s) {
    session::TelemetryHistory history(testing::phantom_1_0().geometry, servo_hz);
    for (int tick = 0; tick < static_cast<int>(duration_s * servo_hz); ++tick) {
        servo::ServoSample sample;
        sample.time_s = tick / servo_hz;
        sample.tip_m = {0.02 * std::cos(sample.time_s), 0.01, 0.02 * std::sin(sample.time_s)};
        sample.tip_force_N = {0.0, 0.1 * sample.time_s, 0.0};
        history.add(sample);
    }
    return history;
}

TEST(RecentTrace, HoldsTheLastFiveSecondsWithTheirForces) {
    for (const double servo_hz : {1000.0, 250.0, 10'000.0}) {
        const session::TelemetryHistory history = circled(servo_hz, 7.0);
        for (const std::optional<double> &until_s : {std::optional<double>(), std::optional(6.0)}) {
            const double end_s = until_s.value_or(7.0 - 1.0 / servo_hz);
            const auto trace_N = recent_trace(history.store(), until_s);
            EXPECT_NEAR(static_cast<double>(trace_N.size()), 500.0,
                        130.0); // whole rows: 8 to 12 ms
            double before_s = end_s - 5.0 - 0.02;
            for (const PlacedValue &place : trace_N) {
                const double then_s = 10.0 * place.value;
                EXPECT_GT(then_s, before_s);
                EXPECT_LT(then_s, before_s + 0.035);
                EXPECT_LT(
                    (place.at_m - Vector3(0.02 * std::cos(then_s), 0.01, 0.02 * std::sin(then_s)))
                        .norm(),
                    1e-7); // the store keeps floats where they are exact; force and place
                before_s = then_s;
            }
            EXPECT_NEAR(before_s, end_s, 1.0 / servo_hz + 1e-9); // up to where the tip is
        }
    }
}

TEST(RecentTrace, StandsStillWhileItGrows) {
    // The same rows in every frame, or the trace would flicker.
    const auto shorter = recent_trace(circled(1000.0, 6.5).store(), {});
    const auto longer = recent_trace(circled(1000.0, 6.507).store(), {});
    for (std::size_t i = 10; i + 1 < shorter.size(); ++i) { // the last is where the tip was then
        EXPECT_TRUE(std::ranges::any_of(longer, [&](const PlacedValue &place) {
            return place.at_m == shorter[i].at_m;
        })) << i;
    }
    EXPECT_TRUE(recent_trace(circled(1000.0, 0.001).store(), {}).empty());
}

TEST(ShownValues, AreComputedForWhatIsSwitchedOnOnly) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const session::TelemetryHistory history = circled(1000.0, 1.0);
    servo::ServoSample now;
    now.theta_rad = device::motor_from_joint(device.geometry, {0.1, 0.2, -0.1});
    now.tip_m = device::tip_position_m(device.geometry, {0.1, 0.2, -0.1});
    now.contact.touching = true;
    now.contact.normal = Vector3::UnitY();
    now.contact.x0_m = now.tip_m + 0.002 * now.contact.normal;
    now.contact.eta = 0.0;
    now.x_Sd_m = now.contact.x0_m;
    now.alpha_rad2_per_m2 = 5000.0;
    const PlotSubject subject{history.store()};
    ShownValues values;
    const TouchValues &none = values.at(ShownThings(), device, now, subject);
    EXPECT_FALSE(none.set_point_m || none.inverse_force_N || none.transpose_force_N ||
                 none.inverse_stiffness_N_per_m || none.workspace);
    EXPECT_TRUE(none.trace_N.empty());
    ShownThings shown;
    for (const OverlayStyle &look : kThings) {
        shown.show(look.thing, true);
    }
    const TouchValues all = values.at(shown, device, now, subject);
    EXPECT_TRUE(all.set_point_m && all.inverse_force_N && all.transpose_force_N &&
                all.inverse_stiffness_N_per_m && all.workspace && !all.trace_N.empty());
    // Computed once for a device and a tuning, whichever map is in use.
    now.tuning.map = control::MotionMap::inverse;
    EXPECT_EQ(values.at(shown, device, now, subject).workspace, all.workspace);
    now.tuning.K_P_V_per_rad *= 2.0;
    const TouchValues stiffer = values.at(shown, device, now, subject);
    EXPECT_NEAR(stiffer.workspace->largest / all.workspace->largest, 2.0, 1e-9); // (13), (27)
    shown.show(Thing::direction_errors, true);                                   // instead
    EXPECT_LT(values.at(shown, device, now, subject).workspace->largest, 1.6);   // rad
    now.contact.touching = false;
    const TouchValues free = values.at(shown, device, now, subject);
    EXPECT_FALSE(free.set_point_m || free.inverse_force_N || free.transpose_force_N);
    EXPECT_TRUE(free.inverse_stiffness_N_per_m); // in free space, too
}

} // namespace
} // namespace springdrive::app

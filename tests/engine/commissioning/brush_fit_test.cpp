// Covers engine/commissioning/brush_fit.cpp: against a motor whose current is integrated from (1)
// with (6) in much shorter steps.
#include "engine/commissioning/brush_fit.h"

#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace springdrive::commissioning {
namespace {

/// A motor that is turned to and fro, against a drag between two levels.
struct DraggedMotor {
    double resistance_Ohm = 2.25;
    double brush_voltage_V = 0.0;
    double brush_current_A = 0.01;
    double offset_A = 0.012;
    double torque_constant_share = 1.02;
    double low_A = 0.2;
    double high_A = 0.8;
    double whole_rad_per_s = 2.0; ///< from which on the drag is whole
};

constexpr double kStep_s = 1e-3;

BrushEstimate fitted(const DraggedMotor &truth, double duration_s, unsigned seed = 1) {
    device::DeviceDescription device = testing::phantom_1_0();
    device::MotorParameters &motor = device.motor[0];
    motor.resistance_rise_per_K = 0.0;
    const double k_T = truth.torque_constant_share * motor.torque_constant_Nm_per_A;
    const double R_hat_Ohm = 1.4;
    const auto theta_rad = [](double time_s) {
        return 5.0 * std::sin(2.0 * std::numbers::pi * 0.37 * time_s);
    };
    const auto rate_rad_per_s = [&](double time_s) {
        return (theta_rad(time_s + 1e-6) - theta_rad(time_s - 1e-6)) / 2e-6;
    };
    std::mt19937 random(seed);
    std::normal_distribution<double> noise_A(0.0, device.current_sensing.noise_A);
    const double resolution_A = device.current_sensing.resolution_A;
    double current_A = 0.0; // as it is
    const auto measured_A = [&] {
        return resolution_A *
               std::round((current_A + truth.offset_A + noise_A(random)) / resolution_A);
    };
    const auto counted_rad = [&](double time_s) {
        return device.rad_per_count() * std::round(theta_rad(time_s) / device.rad_per_count());
    };
    BrushFit fit(device, 0, kStep_s);
    control::DrivenInterval interval;
    interval.duration_s = kStep_s;
    interval.R_hat_Ohm = R_hat_Ohm;
    interval.after_A = measured_A();
    interval.after_rad = counted_rad(0.0);
    for (double time_s = 0.0; time_s < duration_s; time_s += kStep_s) {
        interval.before_A = interval.after_A;
        interval.before_rad = interval.after_rad;
        const double level_A =
            truth.low_A + 0.5 * (truth.high_A - truth.low_A) *
                              (1.0 - std::cos(2.0 * std::numbers::pi * 1.1 * time_s));
        const double share = std::tanh(rate_rad_per_s(time_s) / truth.whole_rad_per_s);
        interval.e_W_V =
            k_T * rate_rad_per_s(time_s) -
            ((truth.resistance_Ohm - R_hat_Ohm) * level_A + truth.brush_voltage_V) * share;
        constexpr int kSteps = 50;
        constexpr double h = kStep_s / kSteps;
        for (int i = 0; i < kSteps; ++i) {
            // (6) acts on what the sensor reads. Midpoint rule, in two rounds.
            const double speed_rad_per_s = rate_rad_per_s(time_s + (i + 0.5) * h);
            double middle_A = current_A;
            for (int round = 0; round < 2; ++round) {
                const double net_V =
                    interval.e_W_V + R_hat_Ohm * (middle_A + truth.offset_A) -
                    truth.resistance_Ohm * middle_A -
                    truth.brush_voltage_V * std::tanh(middle_A / truth.brush_current_A) -
                    k_T * speed_rad_per_s;
                middle_A = current_A + (round == 0 ? 0.5 : 1.0) * h * net_V / motor.inductance_H;
            }
            current_A = middle_A;
        }
        interval.after_A = measured_A();
        interval.after_rad = counted_rad(time_s + kStep_s);
        fit.update(interval);
    }
    return fit.estimate();
}

// Curves between two of the 18 are linear in between: off by 0.4 % of V_b at most, at a ratio of
// 1.19 of their i_b, and in R by as much at half an ampere.
constexpr double kBetween = 0.004;

TEST(BrushFit, TellsVbFromRAndWhereItBends) {
    for (const auto &[brush_V, brush_A] :
         {std::pair(0.0, 0.05), std::pair(0.02, 0.03), std::pair(0.1, 0.1), std::pair(0.2, 0.01),
          std::pair(0.5, 0.05), std::pair(0.5, 0.2)}) {
        DraggedMotor truth;
        truth.brush_voltage_V = brush_V;
        truth.brush_current_A = brush_A;
        const BrushEstimate found = fitted(truth, 30.0);
        EXPECT_NEAR(found.voltage_V, brush_V, 4.0 * found.deviation_V + kBetween * brush_V)
            << brush_V << ' ' << brush_A;
        EXPECT_NEAR(found.resistance.resistance_Ohm, truth.resistance_Ohm,
                    4.0 * found.resistance.deviation_Ohm + kBetween * brush_V / 0.5)
            << brush_V << ' ' << brush_A;
        EXPECT_LT(found.deviation_V, 1e-3 + 0.002 * brush_V); // and what a film may move
        EXPECT_LT(found.resistance.deviation_Ohm, 2e-3);
        EXPECT_LE(found.min_A, 1.05 * brush_A) << brush_V;
        EXPECT_GE(found.max_A, brush_A / 1.05) << brush_V;
        if (brush_V == 0.0) {
            EXPECT_EQ(found.min_A, kMinBrush_A);
            EXPECT_EQ(found.max_A, kMaxBrush_A);
        } else if (brush_A > kMinBrush_A) {
            EXPECT_LT(found.max_A - found.min_A, 0.5 * (kMaxBrush_A - kMinBrush_A)) << brush_V;
        }
    }
}

TEST(BrushFit, NeedsTwoLevels) {
    DraggedMotor truth;
    truth.brush_voltage_V = 0.05;
    truth.whole_rad_per_s = 0.05; // or the way to the level tells as much
    const BrushEstimate two = fitted(truth, 20.0);
    truth.low_A = truth.high_A = 0.5;
    const BrushEstimate one = fitted(truth, 20.0);
    EXPECT_GT(one.deviation_V, 5.0 * two.deviation_V);
    EXPECT_GT(one.resistance.deviation_Ohm, 5.0 * two.resistance.deviation_Ohm);
    EXPECT_FALSE(std::isfinite(fitted(truth, 3.0).deviation_V));
}

} // namespace
} // namespace springdrive::commissioning

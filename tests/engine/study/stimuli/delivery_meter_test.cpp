// Covers engine/study/stimuli/delivery_meter.cpp: samples made up with known values are measured
// with these.
#include "tests/engine/study/stimuli/made_up_samples.h"

#include "base/degrees.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace springdrive::study {
namespace {

using made_up::kPeriod_s;
using made_up::kSpot_m;
using made_up::MadeUpTrial;
using made_up::press_of_a_second;

TEST(DeliveryMeter, ReadsStiffnessDirectionAndPressOffTheSettledPart) {
    constexpr double kStiffness = 1234.0;
    MadeUpTrial trial(press_of_a_second());
    trial.rest();
    trial.touch(kSpot_m);
    for (int tick = 0; tick < 1000; ++tick) {
        const double now_s = tick * kPeriod_s;
        // It wavers; what it does in the first half does not count.
        const double deep_m = 8e-4 + 1e-4 * std::sin(20.0 * now_s);
        const double lean = std::tan(25.0 * kRadiansPerDegree);
        const double pressed_N = (now_s < 0.4 ? 3.0 : 1.0) * kStiffness * deep_m;
        trial.sample.tip_m = kSpot_m - deep_m * Vector3::UnitY();
        trial.sample.tip_force_N = pressed_N * Vector3(0.01, 1.0, lean);
        trial.tick();
    }
    const StimulusMeasures found = trial.meter.delivered().measures;
    EXPECT_NEAR(found.stiffness_N_per_m.value(), kStiffness, 1e-9 * kStiffness);
    EXPECT_NEAR(found.turn_deg.value(), 25.0, 1e-9); // x × y = z
    EXPECT_NEAR(found.across_deg.value(),
                std::atan(0.01 * std::cos(25.0 * kRadiansPerDegree)) * kDegreesPerRadian, 1e-9);
    // The sine's mean over half a second is below 2/(20 · 0.5) of its amplitude.
    EXPECT_NEAR(found.press_N.value(), kStiffness * 8e-4, kStiffness * 1e-4 * 0.2);
    EXPECT_FALSE(found.speed_m_per_s);
    EXPECT_FALSE(found.pulse_N);
}

TEST(DeliveryMeter, SaysNothingOfWhatDidNotHappen) {
    MadeUpTrial trial(press_of_a_second());
    trial.rest();
    trial.ticks(2.0);
    EXPECT_EQ(trial.meter.delivered().measures, StimulusMeasures{});
}

/// A pulse on top of a law whose voltage and motion are known: the law's current is that of (11).
TEST(DeliveryMeter, FindsThePulseInCurrentsOfALawThatMoves) {
    Stimulus stimulus = press_of_a_second();
    stimulus.form = StimulusForm::pulse;
    stimulus.pulse = {0.9, 25.0};
    MadeUpTrial trial(stimulus);
    trial.rest();
    trial.touch(kSpot_m);
    trial.sample.tip_m = kSpot_m - 5e-4 * Vector3::UnitY();
    const double dR = MadeUpTrial::kResidual_Ohm;
    const double L = trial.device.motor[0].inductance_H;
    const Vector3 k_T = control::torque_constants(trial.device);
    const Vector3 lean = Vector3(0.0, std::cos(0.5), std::sin(0.5)); // 0.5 rad towards z
    Vector3 law_A = Vector3::Zero();
    Vector3 law_V = Vector3::Zero();
    const Vector3 theta_rad = trial.sample.theta_rad;
    for (int tick = 0; tick < 1000; ++tick) {
        const double now_s = tick * kPeriod_s;
        const Vector3 before_rad = trial.sample.theta_rad;
        // Small enough that the pose, and so J, stays the same to 1e-4.
        trial.sample.theta_rad =
            theta_rad + 2e-4 * std::sin(40.0 * now_s) * Vector3(1.0, -2.0, 1.5);
        if (tick > 0) {
            const Vector3 rate = (trial.sample.theta_rad - before_rad) / kPeriod_s;
            const double left = std::exp(-dR * kPeriod_s / L);
            law_A = left * law_A + (1.0 - left) / dR * (law_V - k_T.cwiseProduct(rate));
        }
        law_V = Vector3(0.3, 0.1, -0.2) + 0.05 * std::sin(60.0 * now_s) * Vector3::Ones();
        trial.sample.transfer_offset_V = 0.4 * Vector3(std::sin(now_s), 0.3, 0.1);
        trial.sample.command.e_W_V = law_V + trial.sample.transfer_offset_V;
        const double share =
            now_s > 0.5 && now_s < 0.54
                ? 0.5 * (1.0 - std::cos(2.0 * std::numbers::pi * 25.0 * (now_s - 0.5)))
                : 0.0;
        trial.sample.current_A = law_A;
        trial.sample.tip_force_N =
            trial.J.transpose().inverse() * k_T.cwiseProduct(law_A) + 0.9 * share * lean;
        trial.tick();
    }
    const StimulusMeasures found = trial.meter.delivered().measures;
    // J of the moving pose is off by some 1e-4, of law forces of 1 N.
    EXPECT_NEAR(found.pulse_N.value(), 0.9, 0.9 * 2e-3);
    EXPECT_NEAR(found.turn_deg.value(), 0.5 * kDegreesPerRadian, 0.1);
    EXPECT_NEAR(found.across_deg.value(), 0.0, 0.1);
}

TEST(DeliveryMeter, ReadsTheSpeedOfABlowAtTheTouch) {
    Stimulus stimulus = press_of_a_second();
    stimulus.form = StimulusForm::blow;
    MadeUpTrial trial(stimulus);
    trial.rest();
    trial.sample.theta_rate_rad_per_s = trial.J.inverse() * Vector3(0.05, -0.2, 0.0);
    trial.ticks(0.1); // ten times the mean's time: e^(−10) is missing
    trial.sample.theta_rate_rad_per_s.setZero();
    trial.touch(kSpot_m);
    trial.sample.tip_force_N = Vector3(0.0, 2.0, 0.0);
    trial.ticks(0.1);
    const StimulusMeasures found = trial.meter.delivered().measures;
    EXPECT_NEAR(found.speed_m_per_s.value(), 0.2, 1e-4 * 0.2);
    EXPECT_NEAR(found.turn_deg.value(), 0.0, 1e-12);
}

TEST(DeliveryMeter, CountsDeadlinesAndKeepsPeaks) {
    MadeUpTrial trial(press_of_a_second());
    trial.rest();
    trial.touch(kSpot_m);
    trial.sample.missed_in_a_row = 3;
    trial.sample.missed_deadlines = 3;
    trial.sample.tip_force_N = Vector3(0.0, 3.0, 4.0);
    trial.tick();
    trial.sample.missed_in_a_row = 0;
    trial.sample.missed_deadlines = 0;
    trial.sample.tip_force_N = Vector3(0.0, 1.0, 0.0);
    trial.tick();
    const DeliveredStimulus delivered = trial.meter.delivered();
    EXPECT_DOUBLE_EQ(delivered.lateness_s, 3.0 * kPeriod_s);
    EXPECT_EQ(delivered.missed_deadlines, 3U);
    EXPECT_DOUBLE_EQ(delivered.peak_force_N, 5.0);
    EXPECT_FALSE(delivered.is_limited);
}

} // namespace
} // namespace springdrive::study

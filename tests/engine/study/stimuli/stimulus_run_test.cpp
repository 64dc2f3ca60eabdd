// Covers engine/study/stimuli/stimulus_run.cpp: phases and inputs, on samples that are made up.
#include "tests/engine/study/stimuli/made_up_samples.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::study {
namespace {

using made_up::kPeriod_s;
using made_up::kSpot_m;
using made_up::MadeUpTrial;
using made_up::press_of_a_second;

TEST(StimulusRun, WaitsForAHandAtRestNearTheStart) {
    MadeUpTrial trial(press_of_a_second());
    trial.sample.tip_m.y() += StimulusRun::kNearStart_m + 1e-4;
    trial.ticks(2.0);
    EXPECT_EQ(trial.run.phase(), StimulusPhase::waiting) << "too far";
    trial.sample.tip_m.y() -= 2e-4;
    trial.sample.safety.state = servo::SafetyState::starting;
    trial.ticks(2.0);
    EXPECT_EQ(trial.run.phase(), StimulusPhase::waiting) << "the servo does not run yet";
    trial.sample.safety.state = servo::SafetyState::running;
    trial.ticks(0.5 - servo::RestDetector::kTime_s - 2.0 * kPeriod_s);
    EXPECT_EQ(trial.run.phase(), StimulusPhase::waiting);
    trial.sample.tip_m.y() -= 2e-3;
    trial.ticks(0.3);
    EXPECT_EQ(trial.run.phase(), StimulusPhase::waiting) << "it moved";
    trial.ticks(0.5);
    EXPECT_EQ(trial.run.phase(), StimulusPhase::approaching);
}

TEST(StimulusRun, FailsWhereTheTipDoesNotTouchInTime) {
    MadeUpTrial trial(press_of_a_second());
    trial.rest();
    trial.ticks(1.0 - 2.0 * kPeriod_s);
    EXPECT_EQ(trial.run.phase(), StimulusPhase::approaching);
    trial.ticks(4.0 * kPeriod_s);
    EXPECT_EQ(trial.run.failure(), StimulusFailure::never_touched);
}

TEST(StimulusRun, HasItsOwnTuningInContactOnlyAndGlidesBackBeforeTheHandLeaves) {
    Stimulus stimulus = press_of_a_second();
    stimulus.contact.dR_Ohm = 0.3;
    stimulus.free_space.dR_Ohm = 0.8;
    MadeUpTrial trial(stimulus);
    trial.rest();
    EXPECT_EQ(trial.inputs.tuning.dR_Ohm, 0.8);
    trial.touch(kSpot_m);
    trial.tick();
    EXPECT_EQ(trial.run.phase(), StimulusPhase::presenting);
    EXPECT_EQ(trial.inputs.tuning.dR_Ohm, 0.3);
    trial.lift(); // a bounce
    trial.tick();
    EXPECT_EQ(trial.inputs.tuning.dR_Ohm, 0.8);
    trial.touch(kSpot_m);
    trial.ticks(1.0 - 3.0 * kPeriod_s);
    EXPECT_EQ(trial.run.phase(), StimulusPhase::presenting);
    EXPECT_EQ(trial.inputs.tuning.dR_Ohm, 0.3);
    trial.ticks(4.0 * kPeriod_s);
    EXPECT_EQ(trial.run.phase(), StimulusPhase::gliding_back);
    EXPECT_EQ(trial.inputs.tuning.dR_Ohm, 0.8);
    trial.ticks(glide_back_s(stimulus));
    EXPECT_EQ(trial.run.phase(), StimulusPhase::leaving);
    trial.ticks(1.0);
    EXPECT_EQ(trial.run.phase(), StimulusPhase::leaving) << "until it has left";
    trial.lift();
    trial.tick();
    EXPECT_EQ(trial.run.phase(), StimulusPhase::done);
    EXPECT_EQ(trial.run.failure(), StimulusFailure::none);
}

TEST(StimulusRun, HoldsX0InACupFromTheTouchToTheEnd) {
    Stimulus stimulus = press_of_a_second();
    stimulus.hold = Hold::cup;
    MadeUpTrial trial(stimulus);
    trial.rest();
    EXPECT_FALSE(trial.inputs.fixed_x0_m);
    EXPECT_EQ(trial.inputs.tuning.alpha_mode, control::AlphaMode::on_the_fly);
    trial.sample.tip_m = kSpot_m;
    trial.touch(kSpot_m);
    trial.tick();
    ASSERT_TRUE(trial.inputs.fixed_x0_m);
    EXPECT_EQ(*trial.inputs.fixed_x0_m, kSpot_m);
    // α stays what it was at the touch.
    EXPECT_EQ(trial.inputs.tuning.alpha_mode, control::AlphaMode::by_hand);
    EXPECT_EQ(trial.inputs.tuning.alpha_rad2_per_m2, 5000.0);
    trial.sample.alpha_bound_rad2_per_m2 = 5100.0;
    trial.ticks(0.9);
    EXPECT_EQ(trial.inputs.tuning.alpha_rad2_per_m2, 5000.0);
    EXPECT_EQ(*trial.inputs.fixed_x0_m, kSpot_m);
    trial.ticks(0.2); // nothing has to glide back
    EXPECT_EQ(trial.run.phase(), StimulusPhase::leaving);
    EXPECT_FALSE(trial.inputs.fixed_x0_m);
    EXPECT_EQ(trial.inputs.tuning.alpha_mode, control::AlphaMode::on_the_fly);
}

TEST(StimulusRun, FailsWhereTheHandLeavesEarly) {
    MadeUpTrial on_surface(press_of_a_second());
    on_surface.rest();
    on_surface.touch(kSpot_m);
    on_surface.ticks(0.1);
    on_surface.lift();
    on_surface.ticks(StimulusRun::kBounce_s - 2.0 * kPeriod_s);
    EXPECT_EQ(on_surface.run.failure(), StimulusFailure::none);
    on_surface.ticks(4.0 * kPeriod_s);
    EXPECT_EQ(on_surface.run.failure(), StimulusFailure::left_early);

    Stimulus stimulus = press_of_a_second();
    stimulus.hold = Hold::cup;
    MadeUpTrial in_cup(stimulus);
    in_cup.rest();
    in_cup.touch(kSpot_m);
    in_cup.sample.tip_m = kSpot_m + 0.9 * StimulusRun::kOutOfCup_m * Vector3::UnitY();
    in_cup.ticks(0.2);
    EXPECT_EQ(in_cup.run.failure(), StimulusFailure::none);
    in_cup.sample.tip_m = kSpot_m + 1.1 * StimulusRun::kOutOfCup_m * Vector3::UnitY();
    in_cup.tick();
    EXPECT_EQ(in_cup.run.failure(), StimulusFailure::left_early);
    EXPECT_FALSE(in_cup.inputs.fixed_x0_m) << "nothing holds the hand any more";

    stimulus = press_of_a_second();
    stimulus.form = StimulusForm::blow;
    MadeUpTrial blow(stimulus);
    blow.rest();
    blow.touch(kSpot_m);
    blow.tick();
    blow.lift();
    blow.ticks(0.5);
    EXPECT_EQ(blow.run.failure(), StimulusFailure::none) << "a blow may bounce";
}

TEST(StimulusRun, EndsWithATripOfTheMonitor) {
    MadeUpTrial trial(press_of_a_second());
    trial.rest();
    trial.sample.safety.state = servo::SafetyState::tripped;
    trial.tick();
    EXPECT_EQ(trial.run.failure(), StimulusFailure::tripped);
    EXPECT_TRUE(trial.run.is_over());
}

/// With L di/dt: at the middle of a pulse the force is at its height and its rate is zero; at a
/// quarter it is half of it, and the voltage leads by L/dR of the rate.
TEST(StimulusRun, PushesWithThePulseAtRest) {
    Stimulus stimulus = press_of_a_second();
    stimulus.form = StimulusForm::pulse;
    stimulus.pulse = {1.2, 10.0};
    stimulus.direction = Vector3(0.6, 0.8, 0.0);
    MadeUpTrial trial(stimulus);
    trial.rest();
    trial.touch(kSpot_m);
    trial.ticks(0.5 - kPeriod_s);
    EXPECT_LT(trial.inputs.excitation_V.norm(), 1e-12) << "before the pulse";
    const double L_over_dR_s = trial.device.motor[0].inductance_H / MadeUpTrial::kResidual_Ohm;
    for (int i = 0; i < 110; ++i) {
        trial.tick();
        const double since_s = trial.run.presented_s() + 0.5 * kPeriod_s - 0.5;
        const double w = 2.0 * std::numbers::pi * 10.0;
        const bool is_within = since_s >= 0.0 && since_s <= 0.1;
        const double wanted_N =
            is_within
                ? 0.6 * (1.0 - std::cos(w * since_s) + w * L_over_dR_s * std::sin(w * since_s))
                : 0.0;
        const Vector3 pushed_N = trial.force_of_N(trial.inputs.excitation_V);
        EXPECT_LT((pushed_N - wanted_N * stimulus.direction).norm(), 1e-9) << since_s;
    }
}

TEST(StimulusRun, AStrokeIsPresentedInFreeSpace) {
    Stimulus stimulus = press_of_a_second();
    stimulus.form = StimulusForm::stroke;
    stimulus.free_space.dR_Ohm = 0.7;
    MadeUpTrial trial(stimulus);
    trial.rest();
    EXPECT_EQ(trial.run.phase(), StimulusPhase::presenting);
    EXPECT_EQ(trial.inputs.tuning.dR_Ohm, 0.7);
    trial.ticks(1.0 + 2.0 * kPeriod_s);
    EXPECT_EQ(trial.run.phase(), StimulusPhase::done);
}

} // namespace
} // namespace springdrive::study

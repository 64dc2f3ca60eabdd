// Covers engine/study/stimuli/{stimulus,stimulus_run}.cpp: the steering on a spring
// K without a device, against closed forms; phases, inputs and measures on samples that are made
// up.
#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/servo/servo_inputs.h"
#include "engine/study/stimuli/stimulus.h"
#include "tests/support/devices.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace springdrive::study {
namespace {

/// cos φ along the normal, sin φ along axis × normal, and e along the axis: written out.
TEST(ForceAngles, AreThoseOfAForceWrittenOut) {
    const TurnFrame frame{Vector3(0.0, 0.6, 0.8), Vector3::UnitX()};
    const Vector3 towards(0.0, -0.8, 0.6); // x × (0, 0.6, 0.8)
    for (const double turn_deg : {-80.0, -20.0, 0.0, 3.0, 60.0, 89.0}) {
        const double phi = turn_deg * kRadiansPerDegree;
        const Vector3 square = std::cos(phi) * frame.normal + std::sin(phi) * towards;
        const ForceAngles in_plane = force_angles(frame, 2.5 * square);
        EXPECT_NEAR(in_plane.turn_deg, turn_deg, 1e-12);
        EXPECT_NEAR(in_plane.across_deg, 0.0, 1e-12);
        const ForceAngles across =
            force_angles(frame, square + std::tan(5.0 * kRadiansPerDegree) * frame.turn_axis);
        EXPECT_NEAR(across.turn_deg, turn_deg, 1e-12);
        EXPECT_NEAR(across.across_deg, 5.0, 1e-12);
    }
}

TEST(Pulse, HasTheImpulseOfHalfItsHeightAndEndsAtRest) {
    const Pulse pulse{1.5, 20.0};
    EXPECT_DOUBLE_EQ(pulse.force_N(0.5 * pulse.length_s()), 1.5);
    constexpr int kSteps = 1000; // the midpoint rule is exact for whole periods of a sine
    double impulse_Ns = 0.0;
    for (int i = 0; i < kSteps; ++i) {
        const double since_s = (i + 0.5) / kSteps * pulse.length_s();
        impulse_Ns += pulse.force_N(since_s) * pulse.length_s() / kSteps;
        constexpr double kStep_s = 1e-6; // error of the difference: F''' h²/6 = 5e-7 N/s
        EXPECT_NEAR(pulse.rate_N_per_s(since_s),
                    (pulse.force_N(since_s + kStep_s) - pulse.force_N(since_s - kStep_s)) /
                        (2.0 * kStep_s),
                    1e-5);
    }
    EXPECT_NEAR(impulse_Ns, 0.5 * 1.5 / 20.0, 1e-14);
    for (const double outside_s : {-1e-9, 0.05 + 1e-9, 1.0}) {
        EXPECT_EQ(pulse.force_N(outside_s), 0.0);
        EXPECT_EQ(pulse.rate_N_per_s(outside_s), 0.0);
    }
}

TEST(Pulse, BeginsInTheMiddleOrSoThatItEndsInTime) {
    Stimulus stimulus;
    stimulus.presentation_s = 0.6;
    stimulus.pulse = {1.0, 30.0};
    EXPECT_DOUBLE_EQ(stimulus.pulse_from_s(), 0.3);
    stimulus.pulse.frequency_hz = 2.5; // 0.4 s
    EXPECT_DOUBLE_EQ(stimulus.pulse_from_s(), 0.6 - 0.4 - kAfterPulse_s);
}

TEST(Stimulus, GlidesBackWhereDROrLambdaDifferAndFromASteeredForce) {
    Stimulus stimulus;
    stimulus.contact.K_P_V_per_rad = 3.0;
    EXPECT_EQ(glide_back_s(stimulus), 0.0);
    stimulus.is_steered = true;
    EXPECT_EQ(glide_back_s(stimulus), 0.25);
    stimulus.contact.lambda_rad_per_s = 999.0;
    EXPECT_EQ(glide_back_s(stimulus), 0.5);
    stimulus.contact.lambda_rad_per_s = stimulus.free_space.lambda_rad_per_s;
    stimulus.contact.dR_Ohm = 0.6;
    EXPECT_EQ(glide_back_s(stimulus), 0.5);
    stimulus.min_glide_back_s = 0.7;
    EXPECT_EQ(glide_back_s(stimulus), 0.7);
    stimulus.form = StimulusForm::stroke;
    EXPECT_EQ(glide_back_s(stimulus), 0.0);
}

constexpr double kTick_s = 1e-5; ///< so short that the closed forms of continuous time hold
constexpr double kStiffness_N_per_m = 1500.0;
constexpr double kMuch_J = 1e3;
constexpr double kMuch_N = 1e3;

const Vector3 kNormal = Vector3::UnitY();

/// Turned about the x axis: towards z.
Vector3 direction_of(double turn_deg) {
    const double phi = turn_deg * kRadiansPerDegree;
    return {0.0, std::cos(phi), std::sin(phi)};
}

/// A spring held at the origin, with what the steering adds.
struct SteeredSpring {
    ForceSteering steering;
    Vector3 added_N{Vector3::Zero()};

    [[nodiscard]] Vector3 force_N(const Vector3 &tip_m) const {
        return added_N - kStiffness_N_per_m * tip_m;
    }
    void tick(const Vector3 &tip_m, double share = 1.0) {
        added_N = steering.update(tip_m, force_N(tip_m), share);
    }
};

SteeredSpring steered(double turn_deg, ForceSteering::Pace pace = ForceSteering::Pace::slow,
                      double max_work_J = kMuch_J) {
    return {ForceSteering(kNormal, direction_of(turn_deg), pace, max_work_J, kMuch_N, kTick_s)};
}

/// Where a massless hand of stiffness k yields to; it is pressed in by `deep_m`.
Vector3 yielded_m(const SteeredSpring &spring, double hand_N_per_m, double deep_m) {
    const double along_m = spring.added_N.z() / (kStiffness_N_per_m + hand_N_per_m);
    return {0.0, -deep_m, along_m};
}

TEST(ForceSteering, TurnsTheForceOfAHandOfAnyStiffnessWithTheStatedTimeConstant) {
    for (const double hand_N_per_m : {100.0, 300.0, 1e4}) {
        SteeredSpring spring = steered(40.0);
        const double constant_s =
            ForceSteering::kTime_s * (kStiffness_N_per_m + hand_N_per_m) / hand_N_per_m;
        const auto settled = static_cast<long>(constant_s / kTick_s);
        Vector3 tip_m = yielded_m(spring, hand_N_per_m, 1e-3);
        const double slope = std::tan(40.0 * kRadiansPerDegree);
        for (long tick = 0; tick < 20 * settled; ++tick) {
            spring.tick(tip_m);
            tip_m = yielded_m(spring, hand_N_per_m, 1e-3);
            if (tick + 1 == settled) {
                const Vector3 force_N = spring.force_N(tip_m);
                // The first step of a discrete integral comes a period early: T/τ of it.
                EXPECT_NEAR(force_N.z() / force_N.y() / slope, 1.0 - std::exp(-1.0),
                            kTick_s / ForceSteering::kTime_s);
            }
        }
        const Vector3 force_N = spring.force_N(tip_m);
        EXPECT_NEAR(force_N.z() / force_N.y(), slope, 1e-8); // e^(−20)
        EXPECT_NEAR(force_N.y(), kStiffness_N_per_m * 1e-3, 1e-12) << "the normal part is its own";
        EXPECT_EQ(force_N.x(), 0.0);
    }
}

/// Per turn of a tip that is led round in a circle of radius r, a turned stiffness gives
/// π r² K tan φ. Steered slowly, it gives (tan φ − ω τ)/(1 + ω² τ²) of π r² K: from ω τ = tan φ on
/// it takes.
double work_of_circles_J(SteeredSpring spring, double omega_rad_per_s, int turns) {
    constexpr double kRadius_m = 2e-4;
    const auto ticks = std::lround(2.0 * std::numbers::pi / (omega_rad_per_s * kTick_s));
    double before_J = 0.0;
    for (long tick = 0; tick < turns * ticks; ++tick) {
        if (tick == (turns - 1) * ticks) {
            before_J = spring.steering.work_J();
        }
        const double phase =
            2.0 * std::numbers::pi * static_cast<double>(tick) / static_cast<double>(ticks);
        // Deeper where it moves with the force.
        spring.tick({0.0, -1e-3 - kRadius_m * std::cos(phase), kRadius_m * std::sin(phase)});
    }
    return (spring.steering.work_J() - before_J) /
           (std::numbers::pi * kRadius_m * kRadius_m * kStiffness_N_per_m);
}

TEST(ForceSteering, GivesTheWorkOfItsClosedFormToATipLedRoundInCircles) {
    const double slope = std::tan(30.0 * kRadiansPerDegree);
    for (const double omega_tau : {0.1, 0.3, 1.0, 2.0}) {
        const double omega = omega_tau / ForceSteering::kTime_s;
        EXPECT_NEAR(work_of_circles_J(steered(30.0), omega, 40),
                    (slope - omega_tau) / (1.0 + omega_tau * omega_tau), 5e-3)
            << omega_tau;
    }
}

TEST(ForceSteering, GivesUpBeyondItsWorkAndNotBefore) {
    constexpr double kOmega = 10.0;
    SteeredSpring patient = steered(30.0, ForceSteering::Pace::slow, 1e-3);
    SteeredSpring strict = steered(30.0, ForceSteering::Pace::slow, 1e-4);
    constexpr double kRadius_m = 5e-4;
    constexpr long kTicks = 62'832; // a turn
    double most_J = 0.0;
    for (long tick = 0; tick < 3 * kTicks; ++tick) {
        const double phase = kOmega * kTick_s * static_cast<double>(tick);
        const Vector3 tip_m(0.0, -1e-3 - kRadius_m * std::cos(phase), kRadius_m * std::sin(phase));
        patient.tick(tip_m);
        strict.tick(tip_m);
        most_J = std::max(most_J, patient.steering.work_J());
    }
    ASSERT_GT(most_J, 2e-4);
    ASSERT_LT(most_J, 9.9e-3);
    EXPECT_EQ(patient.steering.has_given_up(), most_J > 1e-3);
    EXPECT_TRUE(strict.steering.has_given_up());
    // A force along the normal: K y is taken off, up to the integral's lag τ K v.
    const Vector3 tip_m(0.0, -1e-3, kRadius_m);
    EXPECT_LT(std::abs(strict.force_N(tip_m).z()),
              1.1 * ForceSteering::kTime_s * kStiffness_N_per_m * kRadius_m * kOmega +
                  kStiffness_N_per_m * kRadius_m);
}

TEST(ForceSteering, TurnsBackToTheNormal) {
    SteeredSpring spring = steered(30.0);
    const Vector3 tip_m(0.0, -1e-3, 0.0);
    for (int i = 0; i < 10'000; ++i) {
        spring.tick(tip_m);
    }
    const double full_N = spring.added_N.norm();
    EXPECT_NEAR(full_N, 1.5 * std::tan(30.0 * kRadiansPerDegree), 1e-3);
    const auto constant = static_cast<int>(ForceSteering::kTime_s / kTick_s);
    for (int i = 0; i < constant; ++i) {
        spring.tick(tip_m, 0.0);
    }
    EXPECT_NEAR(spring.added_N.norm() / full_N, std::exp(-1.0), 1e-3);
}

TEST(ForceSteering, TurnsABlowAtOnce) {
    SteeredSpring spring = steered(30.0, ForceSteering::Pace::prompt);
    spring.tick({0.0, -1e-3, 0.0});
    const double slope = std::tan(30.0 * kRadiansPerDegree);
    // And the integral's first part, T/τ of it.
    EXPECT_NEAR(spring.added_N.z(), 1.5 * slope,
                1.01 * 1.5 * slope * kTick_s / ForceSteering::kTime_s);
}

TEST(ForceSteering, AddsNoMoreThanItsLimit) {
    SteeredSpring spring{ForceSteering(kNormal, direction_of(45.0), ForceSteering::Pace::slow,
                                       kMuch_J, 2.0, kTick_s)};
    for (int i = 0; i < 10'000; ++i) {
        spring.tick({0.0, -2e-3, 0.0}); // asks for 3 N
        EXPECT_LE(spring.added_N.norm(), 2.0 + 1e-12);
    }
    EXPECT_NEAR(spring.added_N.z(), 2.0, 1e-12);
}

// Servo samples made up with known stiffness, force and position: a device in one pose.

constexpr double kPeriod_s = 1e-3;
const Vector3 kSpot_m(0.0, -0.005, -0.015); ///< of the pose, below the start

/// A run and its meter, fed with samples.
class MadeUpTrial {
public:
    explicit MadeUpTrial(const Stimulus &stimulus)
        : device(testing::phantom_1_0()), run(device, stimulus, kPeriod_s),
          meter(device, stimulus, kPeriod_s) {
        const Vector3 q_rad = *device::joint_angles_rad(device.geometry, kSpot_m);
        sample.theta_rad = device::motor_from_joint(device.geometry, q_rad);
        J = device::motor_jacobian(device.geometry, q_rad);
        sample.motor = control::motors_of_file(device.motor);
        sample.safety.state = servo::SafetyState::running;
        sample.alpha_bound_rad2_per_m2 = 5000.0;
        for (Eigen::Index j = 0; j < 3; ++j) {
            sample.command.cancelled_resistance_Ohm[j] =
                device.motor[static_cast<std::size_t>(j)].resistance_Ohm - kResidual_Ohm;
        }
        sample.tip_m = stimulus.start_m;
        sample.contact.x0_m = stimulus.start_m;
    }

    static constexpr double kResidual_Ohm = 0.5;

    void tick() {
        run.update(sample, inputs);
        meter.take(sample, run);
        sample.time_s += kPeriod_s;
    }
    void ticks(double seconds) {
        for (long i = std::lround(seconds / kPeriod_s); i > 0; --i) {
            tick();
        }
    }
    /// At rest at the start until it may approach.
    void rest() {
        while (run.phase() == StimulusPhase::waiting && sample.time_s < 30.0) {
            tick();
        }
    }
    void touch(const Vector3 &x0_m) {
        sample.contact.touching = true;
        sample.contact.x0_m = x0_m;
    }
    void lift() { sample.contact.touching = false; }

    /// The force on the tip at rest that a voltage beyond the law's makes: J⁻ᵀ k_T V/dR.
    [[nodiscard]] Vector3 force_of_N(const Vector3 &voltage_V) const {
        return J.transpose().inverse() * control::torque_constants(device).cwiseProduct(voltage_V) /
               kResidual_Ohm;
    }

    device::DeviceDescription device;
    Matrix3 J;
    servo::ServoSample sample;
    servo::ServoInputs inputs;
    StimulusRun run;
    DeliveryMeter meter;
};

Stimulus press_of_a_second() {
    Stimulus stimulus;
    stimulus.start_m = Vector3(0.0, 0.015, -0.015);
    stimulus.rest_s = 0.5;
    stimulus.approach_s = 1.0;
    stimulus.presentation_s = 1.0;
    return stimulus;
}

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
        const double requested_N =
            is_within
                ? 0.6 * (1.0 - std::cos(w * since_s) + w * L_over_dR_s * std::sin(w * since_s))
                : 0.0;
        const Vector3 pushed_N = trial.force_of_N(trial.inputs.excitation_V);
        EXPECT_LT((pushed_N - requested_N * stimulus.direction).norm(), 1e-9) << since_s;
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

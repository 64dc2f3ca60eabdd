// Covers engine/study/stimuli/force_steering.cpp: on a spring K without a device, against closed
// forms.
#include "engine/study/stimuli/force_steering.h"

#include "base/degrees.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace springdrive::study {
namespace {

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

} // namespace
} // namespace springdrive::study

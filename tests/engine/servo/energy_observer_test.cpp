// Covers engine/servo/energy_observer.h.
#include "engine/servo/energy_observer.h"

#include "tests/support/configurations.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace springdrive::servo {
namespace {

constexpr double kObserverPeriod_s = 1e-3;
constexpr double kLimit_J = 0.03;
constexpr double kForgetsNothing_s = 1e-15; ///< a period too short for any decay

/// The coupling: F = −K d, d from the proxy to the tip; stored energy ½ K d².
struct Spring {
    double stiffness_N_per_m = 1000.0;

    [[nodiscard]] Vector3 force_N(const Vector3 &tip_m) const { return -stiffness_N_per_m * tip_m; }
    [[nodiscard]] double stored_J(const Vector3 &tip_m) const {
        return spring_energy_J(force_N(tip_m), -tip_m, 1.0);
    }
};

void go(EnergyObserver &observer, const Spring &spring, const Vector3 &tip_m) {
    observer.update(tip_m, spring.force_N(tip_m), spring.stored_J(tip_m), 0.0, kLimit_J);
}

TEST(EnergyObserver, AnExactSpringGeneratesNothing) {
    // The trapezoidal rule is exact for a force that is linear in the displacement, for any step.
    std::mt19937_64 random(1);
    for (int run = 0; run < 100; ++run) {
        EnergyObserver observer(kObserverPeriod_s);
        const Spring spring{std::uniform_real_distribution<double>(100.0, 5000.0)(random)};
        const Vector3 first_m = testing::random_vector(random, 5e-3);
        go(observer, spring, first_m);
        for (int tick = 0; tick < 1000; ++tick) {
            go(observer, spring, testing::random_vector(random, 5e-3));
            ASSERT_LT(std::abs(observer.generated_J()), 1e-13); // of about 0.1 J exchanged
        }
        go(observer, spring, first_m);
        ASSERT_LT(std::abs(observer.generated_J()), 1e-13);
    }
}

TEST(EnergyObserver, ASpringThatIsStifferOnTheWayOutGeneratesTheSurplus) {
    // In against K, out against K + ΔK: the hand receives ½ ΔK d² of generated energy, counted once
    // all that it put in is returned. No decay meanwhile.
    const double depth_m = 5e-3;
    const Spring in{1000.0};
    const Spring out{1200.0};
    const double surplus_J = 0.5 * 200.0 * depth_m * depth_m;
    EnergyObserver observer(kForgetsNothing_s);
    constexpr int kSteps = 50;
    for (int step = 0; step <= kSteps; ++step) {
        go(observer, in, Vector3(0.0, -depth_m * step / kSteps, 0.0));
        EXPECT_NEAR(observer.generated_J(), 0.0, 1e-13);
    }
    for (int step = kSteps; step >= 0; --step) {
        const double left_m = depth_m * step / kSteps;
        go(observer, out, Vector3(0.0, -left_m, 0.0));
        const double got_J = 0.5 * 1200.0 * (depth_m * depth_m - left_m * left_m);
        const double put_in_J = 0.5 * 1000.0 * depth_m * depth_m;
        EXPECT_NEAR(observer.generated_J(), std::max(0.0, got_J - put_in_J), 1e-13);
    }
    EXPECT_NEAR(observer.generated_J(), surplus_J, 1e-13);
}

TEST(EnergyObserver, ForceBeyondTheSpringGeneratesTheSurplus) {
    // The law's spring is K throughout; the rendered force is that of K on the way in, and stiffer
    // on the way out, as caused by a lag. Over a closed path ½ ΔK d² is generated.
    const double depth_m = 5e-3;
    const Spring law{1000.0};
    for (const double surplus_N_per_m : {0.0, 100.0, 400.0}) {
        const Spring out{law.stiffness_N_per_m + surplus_N_per_m};
        EnergyObserver observer(kForgetsNothing_s);
        constexpr int kSteps = 50;
        for (int step = 0; step <= kSteps; ++step) {
            go(observer, law, Vector3(0.0, -depth_m * step / kSteps, 0.0));
        }
        for (int step = kSteps; step >= 0; --step) {
            const Vector3 tip_m(0.0, -depth_m * step / kSteps, 0.0);
            observer.update(tip_m, out.force_N(tip_m), law.stored_J(tip_m), 0.0, kLimit_J);
        }
        EXPECT_NEAR(observer.generated_J(), 0.5 * surplus_N_per_m * depth_m * depth_m, 1e-13);
    }
}

TEST(EnergyObserver, ADamperOnlyDissipates) {
    // F = −b v: G decreases by the dissipated energy, −Σ F Δx, down to its lower bound.
    EnergyObserver observer(kForgetsNothing_s);
    double taken_J = 0.0;
    const double force_N = -2.0;
    observer.update(Vector3::Zero(), Vector3(force_N, 0, 0), 0.0, 0.0, kLimit_J);
    for (int tick = 1; tick <= 100; ++tick) {
        observer.update(Vector3(1e-4 * tick, 0, 0), Vector3(force_N, 0, 0), 0.0, 0.0, kLimit_J);
        taken_J += 2.0 * 1e-4;
        EXPECT_NEAR(observer.generated_J(), -taken_J, 1e-13);
    }
}

TEST(EnergyObserver, DecaysWithItsTimeConstantAtAnyRate) {
    for (const double period_s : {1.0 / 250, 1e-3, 1e-4}) {
        EnergyObserver observer(period_s);
        const Vector3 push_N(1.0, 0, 0);
        observer.update(Vector3::Zero(), push_N, 0.0, 0.0, kLimit_J);
        observer.update(Vector3(0.01, 0, 0), push_N, 0.0, 0.0, kLimit_J);
        const double made_J = observer.generated_J();
        EXPECT_NEAR(made_J, 0.01, 1e-15);
        const int ticks = static_cast<int>(std::lround(0.7 / period_s));
        for (int tick = 0; tick < ticks; ++tick) {
            observer.update(Vector3(0.01, 0, 0), Vector3::Zero(), 0.0, 0.0, kLimit_J);
        }
        EXPECT_NEAR(observer.generated_J(), made_J * std::exp(-0.7 / 0.5), 1e-10);
    }
}

TEST(EnergyObserver, CreditIsBounded) {
    // Regardless of the energy put in before, at most twice the limit can be returned.
    EnergyObserver observer(kForgetsNothing_s);
    Vector3 tip_m = Vector3::Zero();
    const auto move = [&](double force_N, double way_m) {
        observer.update(tip_m, Vector3(force_N, 0, 0), 0.0, 0.0, kLimit_J);
        tip_m.x() += way_m;
        observer.update(tip_m, Vector3(force_N, 0, 0), 0.0, 0.0, kLimit_J);
    };
    for (int i = 0; i < 100; ++i) {
        move(-5.0, 0.01);
        ASSERT_GE(observer.generated_J(), -kLimit_J);
    }
    EXPECT_EQ(observer.generated_J(), -kLimit_J);
    move(5.0, 1.99 * kLimit_J / 5.0);
    EXPECT_NEAR(observer.generated_J(), 0.99 * kLimit_J, 1e-15);
    move(5.0, 0.02 * kLimit_J / 5.0);
    EXPECT_GT(observer.generated_J(), kLimit_J);
}

TEST(EnergyObserver, AChangeOfTheSpringIsNotCounted) {
    // Stiffened at 5 mm and then released: 25 mJ more come out than went in, supplied by the
    // operator's change of tuning; any further energy is counted.
    const double depth_m = 5e-3;
    for (const bool told : {false, true}) {
        EnergyObserver observer(kForgetsNothing_s);
        const Spring soft{1000.0};
        const Spring stiff{3000.0};
        const Vector3 pressed_m(0.0, -depth_m, 0.0);
        go(observer, soft, pressed_m);
        const double more_J = stiff.stored_J(pressed_m) - soft.stored_J(pressed_m);
        observer.update(pressed_m, stiff.force_N(pressed_m), stiff.stored_J(pressed_m),
                        told ? more_J : 0.0, kLimit_J);
        EXPECT_EQ(observer.generated_J(), 0.0);
        for (int step = 50; step >= 0; --step) {
            go(observer, stiff, pressed_m * step / 50.0);
        }
        EXPECT_NEAR(observer.generated_J(), told ? 0.0 : 0.025, 1e-13);
    }
}

TEST(EnergyObserver, AnOverestimatedSpringCausesNoFalseAlarm) {
    // The model has twice the stiffness of the force, in and out: nothing is generated.
    EnergyObserver observer(kForgetsNothing_s);
    const Spring force{1000.0};
    const Spring model{2000.0};
    double max_J = 0.0;
    for (int turn = 0; turn < 20; ++turn) {
        for (int step = 0; step <= 100; ++step) {
            const double share = std::sin(std::numbers::pi * step / 100);
            const Vector3 tip_m(0.0, -5e-3 * share, 0.0);
            observer.update(tip_m, force.force_N(tip_m), model.stored_J(tip_m), 0.0, kLimit_J);
            max_J = std::max(max_J, observer.generated_J());
        }
    }
    EXPECT_LT(max_J, 1e-13);
}

TEST(EnergyObserver, RestartsAfterAReset) {
    EnergyObserver observer(kObserverPeriod_s);
    const Vector3 push_N(1.0, 0, 0);
    observer.update(Vector3::Zero(), push_N, 0.0, 0.0, kLimit_J);
    observer.update(Vector3(0.01, 0, 0), push_N, 0.0, 0.0, kLimit_J);
    observer.reset();
    EXPECT_EQ(observer.generated_J(), 0.0);
    observer.update(Vector3(1.0, 0, 0), push_N, 5.0, 0.0, kLimit_J); // no displacement from the
                                                                     // previous position
    EXPECT_EQ(observer.generated_J(), 0.0);
}

TEST(EnergyObserver, ALimitedSpringStoresTheWorkOfStretchingIt) {
    // Compared with the integral of min(K x, share K d) over the displacement, in fine steps.
    const double K_N_per_m = 1500.0;
    const double depth_m = 4e-3;
    for (const double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
        constexpr int kSteps = 20'000;
        double integral_J = 0.0;
        for (int i = 0; i < kSteps; ++i) {
            const double x_m = depth_m * (i + 0.5) / kSteps;
            integral_J += std::min(K_N_per_m * x_m, share * K_N_per_m * depth_m) * depth_m / kSteps;
        }
        const Vector3 stretch_m(0.0, depth_m, 0.0);
        EXPECT_NEAR(spring_energy_J(K_N_per_m * stretch_m, stretch_m, share), integral_J, 1e-9);
    }
}

} // namespace
} // namespace springdrive::servo

// Covers engine/lab/loops/linear_loop.cpp.
#include "engine/lab/loops/linear_loop.h"

#include "tests/support/random_loops.h"
#include "tests/support/sampled_loop.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <random>

namespace springdrive::loops {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Eigen::Index kMotors = 3;

MatrixXd random_symmetric(double scale, std::mt19937_64 &random) {
    testing::Draw draw(random);
    const MatrixXd any =
        MatrixXd::NullaryExpr(kMotors, kMotors, [&] { return draw.even(-1.0, 1.0); });
    return scale * (any * any.transpose() + 0.3 * MatrixXd::Identity(kMotors, kMotors));
}

VectorXd random_values(double low, double high, std::mt19937_64 &random) {
    testing::Draw draw(random);
    return VectorXd::NullaryExpr(kMotors, [&] { return draw.even(low, high); });
}

DrivenLoad random_load(std::mt19937_64 &random) {
    return {random_symmetric(1e-5, random),         random_symmetric(1e-4, random),
            random_symmetric(0.05, random),         random_values(0.01, 0.05, random),
            random_values(-3000.0, -500.0, random), random_values(-100.0, -20.0, random),
            random_values(1000.0, 5000.0, random)};
}

SampledLaw random_law(double delay_periods, std::mt19937_64 &random) {
    SampledLaw law;
    law.per_velocity = -random_symmetric(0.01, random);
    law.per_position = -random_symmetric(1.0, random);
    law.filter_pole = testing::Draw(random).even(0.2, 0.8);
    law.delay_periods = delay_periods;
    return law;
}

/// [θ, θ̇, i] after a time, by Runge-Kutta steps.
VectorXd moved_on(const DrivenLoad &load, VectorXd state, const VectorXd &u, double time_s) {
    const auto rates = [&](const VectorXd &x) {
        const VectorXd theta = x.head(kMotors);
        const VectorXd rate = x.segment(kMotors, kMotors);
        const VectorXd current = x.tail(kMotors);
        VectorXd dx(3 * kMotors);
        dx << rate,
            load.inertia_kg_m2.inverse() *
                (load.torque_Nm_per_A.cwiseProduct(current) - load.damping_Nms_per_rad * rate -
                 load.stiffness_Nm_per_rad * theta),
            load.current_rate_per_current.cwiseProduct(current) +
                load.current_rate_per_velocity.cwiseProduct(rate) +
                load.current_rate_per_command.cwiseProduct(u);
        return dx;
    };
    constexpr int kSteps = 100;
    const double h = time_s / kSteps;
    for (int i = 0; i < kSteps; ++i) {
        const VectorXd k1 = rates(state);
        const VectorXd k2 = rates(state + 0.5 * h * k1);
        const VectorXd k3 = rates(state + 0.5 * h * k2);
        const VectorXd k4 = rates(state + h * k3);
        state += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    return state;
}

double largest(const DrivenLoad &load, const SampledLaw &law) {
    return largest_eigenvalue(
        one_period_map(sampled_load(load, law.period_s, law.delay_periods), law), law,
        load.stiffness_Nm_per_rad);
}

TEST(SampledLoad, IsTheMotionOverAPeriodWithinWhichADelayChangesTheCommand) {
    std::mt19937_64 random(11);
    for (const double fraction : {0.0, 1e-3, 0.25, 0.5, 0.9, 0.999}) {
        const DrivenLoad load = random_load(random);
        const VectorXd u_old = random_values(-1.0, 1.0, random);
        const VectorXd u_new = random_values(-1.0, 1.0, random);
        VectorXd before(3 * kMotors);
        before << random_values(-1.0, 1.0, random), random_values(-50.0, 50.0, random),
            random_values(-1.0, 1.0, random);
        VectorXd given(fraction > 0.0 ? 5 * kMotors : 4 * kMotors);
        given.head(3 * kMotors) = before;
        given.segment(3 * kMotors, kMotors) = u_old;
        given.tail(kMotors) = u_new;
        const VectorXd truth = moved_on(load, moved_on(load, before, u_old, fraction * 1e-3), u_new,
                                        (1.0 - fraction) * 1e-3);
        for (const int whole : {0, 1, 4}) {
            const MatrixXd map = sampled_load(load, 1e-3, whole + fraction);
            ASSERT_EQ(map.cols(), given.size());
            // Steps of 10 µs, fourth order: within 1e-7 of the largest.
            EXPECT_LT((map * given - truth).norm(), 1e-7 * truth.norm()) << fraction;
        }
    }
}

TEST(SampledLoad, OfAWholeDelayIsTheSameToTheLastBit) {
    std::mt19937_64 random(12);
    for (const double delay : {0.0, 1.0, 8.0}) {
        const DrivenLoad load = random_load(random);
        EXPECT_EQ(sampled_load(load, 1e-3, delay), sampled_load(load, 1e-3));
    }
}

/// The servo of docs/design.md, "Sampled forms", sample by sample.
TEST(OnePeriodMap, IsTheServoSampleBySample) {
    std::mt19937_64 random(2);
    for (const double delay : {0.0, 1.0, 2.0, 5.0, 0.3, 0.999, 1.5, 3.001}) {
        const double whole = std::floor(delay);
        const double fraction = delay - whole;
        const DrivenLoad load = random_load(random);
        const SampledLaw law = random_law(delay, random);
        const MatrixXd map = one_period_map(sampled_load(load, law.period_s, delay), law);
        ASSERT_EQ(map.rows(), kMotors * (5 + std::lround(std::ceil(delay))));

        VectorXd plant(3 * kMotors);
        plant << random_values(-1.0, 1.0, random), VectorXd::Zero(2 * kMotors);
        VectorXd before = plant.head(kMotors);
        VectorXd v = VectorXd::Zero(kMotors);
        std::deque<VectorXd> held(static_cast<std::size_t>(whole) + 1, VectorXd::Zero(kMotors));
        VectorXd state = VectorXd::Zero(map.rows());
        state.head(kMotors) = before;
        for (int k = 0; k < 20; ++k) {
            const VectorXd theta = plant.head(kMotors);
            v = law.filter_pole * v + (1.0 - law.filter_pole) * (theta - before) / law.period_s;
            before = theta;
            held.emplace_back(law.per_velocity * v + law.per_position * theta);
            if (fraction > 0.0) {
                plant = moved_on(load, plant, held[0], fraction * law.period_s);
            }
            plant = moved_on(load, plant, held[1], (1.0 - fraction) * law.period_s);
            held.pop_front();
            state = map * state;
            const double scale = plant.norm();
            EXPECT_LT((state.head(kMotors) - plant.head(kMotors)).norm(), 1e-6 * scale);
            EXPECT_LT((state.segment(2 * kMotors, 2 * kMotors) - plant.tail(2 * kMotors)).norm(),
                      1e-6 * scale)
                << "delay " << delay << ", sample " << k;
        }
    }
}

/// A single motor, as verified in sampled_loop_test.cpp.
SampledLoop random_loop(std::mt19937_64 &random) {
    testing::Draw draw(random);
    SampledLoop loop;
    loop.drive.motor = testing::random_motor(random);
    loop.drive.tuning = testing::random_tuning(loop.drive.motor, random);
    loop.drive.tuning.lambda_rad_per_s = 800.0;
    loop.device = {draw.by_ratio(1e-6, 1e-4), draw.by_ratio(1e-6, 1e-3), draw.even(0.0, 0.1)};
    return loop;
}

/// A delay slightly below or above a whole number gives the same as that number. The slope is the
/// same on both sides, too: a command reaches θ through the current and its rate, so that a change
/// at the very end of a period does not affect θ at the next sample.
TEST(LinearLoop, DelaysMeetAtWholeNumbersWithoutAStepOrAKink) {
    std::mt19937_64 random(13);
    for (int i = 0; i < 30; ++i) {
        SampledLoop loop = random_loop(random);
        const auto largest_at = [&loop](double delay) {
            loop.drive.delay_periods = delay;
            return largest_eigenvalue(loop);
        };
        const double d = 1.0 + i % 3;
        const double here = largest_at(d);
        constexpr double kAside = 1e-4;
        const double above = (largest_at(d + kAside) - here) / kAside;
        const double below = (here - largest_at(d - kAside)) / kAside;
        const double nearer = (largest_at(d + 0.1 * kAside) - here) / (0.1 * kAside);
        // First order in what d is aside; the second is some kAside of it. Round-off: an
        // eigenvalue to 1e-13 over 1e-5.
        const double second_order = 1e-2 * std::abs(nearer) + 1e-7;
        EXPECT_NEAR(above, nearer, second_order) << d;
        EXPECT_NEAR(below, nearer, second_order) << d;
        loop.drive.delay_periods = 0.0;
        const double at_zero = largest_eigenvalue(loop);
        EXPECT_NEAR(largest_at(kAside * 1e-3), at_zero,
                    2e-3 * std::abs(largest_at(kAside) - at_zero) + 1e-12);
    }
}

/// A tip on a plane is held in one direction; along the others it may rest anywhere.
TEST(LargestEigenvalue, DirectionsThatNothingPullsBackDoNotCount) {
    std::mt19937_64 random(5);
    for (int i = 0; i < 20; ++i) {
        DrivenLoad load = random_load(random);
        load.stiffness_Nm_per_rad.setZero();
        const Eigen::Vector3d normal = random_values(-1.0, 1.0, random).normalized();
        const MatrixXd share = normal * normal.transpose();
        SampledLaw law;
        law.per_velocity = -1e-3 * share;
        law.per_position = -0.3 * share;
        law.filter_pole = 0.4;
        law.delay_periods = i % 2;
        const MatrixXd map = one_period_map(sampled_load(load, law.period_s), law);
        const VectorXd distances = (map.eigenvalues().array() - 1.0).abs();
        EXPECT_EQ((distances.array() < 1e-8).count(), 2) << "one for each free direction";
        EXPECT_LT(largest(load, law), 1.0 - 1e-6);
        // The third direction counts.
        law.per_position *= 1000.0;
        EXPECT_GT(largest(load, law), 1.0 + 1e-6);
    }
}

TEST(LargestEigenvalue, AFreeMassThatCoastsForEverCounts) {
    DrivenLoad load;
    load.inertia_kg_m2 = MatrixXd::Identity(3, 3) * 1e-5;
    load.damping_Nms_per_rad = load.stiffness_Nm_per_rad = MatrixXd::Zero(3, 3);
    load.torque_Nm_per_A = VectorXd::Zero(3); // motors with open windings
    load.current_rate_per_current = VectorXd::Constant(3, -1000.0);
    load.current_rate_per_velocity = VectorXd::Constant(3, -100.0);
    load.current_rate_per_command = VectorXd::Constant(3, 4000.0);
    SampledLaw law;
    law.per_velocity = law.per_position = MatrixXd::Zero(3, 3);
    law.filter_pole = 0.4;
    EXPECT_NEAR(largest(load, law), 1.0, 1e-9);
    load.damping_Nms_per_rad.diagonal().setConstant(1e-4);
    EXPECT_NEAR(largest(load, law), std::exp(-1e-4 / 1e-5 * 1e-3), 1e-9); // e^(−bT/J)
    // A spring to the ground pulls as well, along its own direction.
    load.stiffness_Nm_per_rad(2, 2) = 1e-3;
    EXPECT_GT(largest(load, law), std::exp(-0.01) + 1e-6) << "b/J is 10, √(k/J) is 10: slower";
}

} // namespace
} // namespace springdrive::loops

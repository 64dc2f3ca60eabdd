// Covers engine/lab/loops/linear_loop.cpp: three coupled motors, with and without further bodies,
// sample by sample, and one motor, by which tests/support/sampled_loop.h is verified.
#include "base/bisection.h"
#include "engine/lab/loops/linear_loop.h"
#include "tests/support/devices.h"
#include "tests/support/sampled_loop.h"
#include "tests/support/stability_cases.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>

namespace springdrive::loops {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Eigen::Index kMotors = 3;

MatrixXd random_symmetric(double scale, std::mt19937_64 &random, Eigen::Index rows = kMotors) {
    testing::Draw draw(random);
    const MatrixXd any = MatrixXd::NullaryExpr(rows, rows, [&] { return draw.even(-1.0, 1.0); });
    return scale * (any * any.transpose() + 0.3 * MatrixXd::Identity(rows, rows));
}

VectorXd random_values(double low, double high, std::mt19937_64 &random,
                       Eigen::Index rows = kMotors) {
    testing::Draw draw(random);
    return VectorXd::NullaryExpr(rows, [&] { return draw.even(low, high); });
}

/// @param n  its coordinates, the motors' first
DrivenLoad random_load(std::mt19937_64 &random, Eigen::Index n = kMotors) {
    return {random_symmetric(1e-5, random, n),      random_symmetric(1e-4, random, n),
            random_symmetric(0.05, random, n),      random_values(0.01, 0.05, random),
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

/// [x, ẋ, i] after a time, by Runge-Kutta steps.
VectorXd moved_on(const DrivenLoad &load, VectorXd state, const VectorXd &u, double time_s) {
    const Eigen::Index n = load.inertia_kg_m2.rows();
    const auto rates = [&](const VectorXd &x) {
        const VectorXd place = x.head(n);
        const VectorXd rate = x.segment(n, n);
        const VectorXd current = x.tail(kMotors);
        VectorXd force = -load.damping_Nms_per_rad * rate - load.stiffness_Nm_per_rad * place;
        force.head(kMotors) += load.torque_Nm_per_A.cwiseProduct(current);
        VectorXd dx(x.size());
        dx << rate, load.inertia_kg_m2.inverse() * force,
            load.current_rate_per_current.cwiseProduct(current) +
                load.current_rate_per_velocity.cwiseProduct(rate.head(kMotors)) +
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
        const Eigen::Index n = kMotors + (fraction > 0.3 ? 2 : 0);
        const DrivenLoad load = random_load(random, n);
        const VectorXd u_old = random_values(-1.0, 1.0, random);
        const VectorXd u_new = random_values(-1.0, 1.0, random);
        VectorXd before(2 * n + kMotors);
        before << random_values(-1.0, 1.0, random, n), random_values(-50.0, 50.0, random, n),
            random_values(-1.0, 1.0, random);
        VectorXd given(before.size() + (fraction > 0.0 ? 2 : 1) * kMotors);
        given.head(before.size()) = before;
        given.segment(before.size(), kMotors) = u_old;
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
        const Eigen::Index n = kMotors + (delay < 2.5 ? 4 : 0);
        const DrivenLoad load = random_load(random, n);
        const SampledLaw law = random_law(delay, random);
        const MatrixXd map = one_period_map(sampled_load(load, law.period_s, delay), law);
        ASSERT_EQ(map.rows(), 2 * n + kMotors * (3 + std::lround(std::ceil(delay))));

        VectorXd plant(2 * n + kMotors);
        plant << random_values(-1.0, 1.0, random, n), VectorXd::Zero(n + kMotors);
        VectorXd before = plant.head(kMotors);
        VectorXd v = VectorXd::Zero(kMotors);
        std::deque<VectorXd> held(static_cast<std::size_t>(whole) + 1, VectorXd::Zero(kMotors));
        VectorXd state = VectorXd::Zero(map.rows());
        state.head(n) = plant.head(n);
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
            EXPECT_LT((state.head(n) - plant.head(n)).norm(), 1e-6 * scale);
            EXPECT_LT((state.segment(n + kMotors, n + kMotors) - plant.tail(n + kMotors)).norm(),
                      1e-6 * scale)
                << "delay " << delay << ", sample " << k;
        }
    }
}

/// A single motor.
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

/// Bodies behind springs follow the motors wherever these may rest; a spring to the ground at the
/// far end of them pulls on the motors, too, however stiff those between are.
TEST(LargestEigenvalue, BodiesThatFollowAFreeMotorDoNotCountEither) {
    std::mt19937_64 random(6);
    for (int i = 0; i < 40; ++i) {
        constexpr Eigen::Index kBodies = 3;
        const double tied = testing::Draw(random).by_ratio(0.1, 1e3);
        DrivenLoad load = random_load(random, kMotors + kBodies);
        const MatrixXd tie = random_symmetric(tied, random);
        load.stiffness_Nm_per_rad << tie, -tie, -tie, tie;
        const Eigen::Vector3d normal = random_values(-1.0, 1.0, random).normalized();
        SampledLaw law;
        law.per_velocity = -1e-3 * normal * normal.transpose();
        law.per_position = -0.3 * normal * normal.transpose();
        law.filter_pole = 0.4;
        law.delay_periods = 0.5 * (i % 3);
        const MatrixXd map =
            one_period_map(sampled_load(load, law.period_s, law.delay_periods), law);
        VectorXd sizes = map.eigenvalues().cwiseAbs();
        const VectorXd distances = (map.eigenvalues().array() - 1.0).abs();
        EXPECT_EQ((distances.array() < 1e-8).count(), 2) << "one for each free direction";
        sizes = (distances.array() < 1e-8).select(0.0, sizes);
        // Round-off of the exponential grows as the square of the fastest mode's rate: measured,
        // 2e-12 for each N·m/rad.
        const double round_off = 1e-11 * (1.0 + tied);
        EXPECT_NEAR(largest(load, law), sizes.maxCoeff(), round_off) << tied;
        load.stiffness_Nm_per_rad.bottomRightCorner(kBodies, kBodies).diagonal().array() += 0.01;
        const double slow = largest(load, law);
        EXPECT_NEAR(slow,
                    one_period_map(sampled_load(load, law.period_s, law.delay_periods), law)
                        .eigenvalues()
                        .cwiseAbs()
                        .maxCoeff(),
                    round_off);
        EXPECT_LT(slow, 1.0 - 1e-6);
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

SampledLoop with_K_P(SampledLoop loop, double K_P_V_per_rad) {
    loop.drive.tuning.K_P_V_per_rad = K_P_V_per_rad;
    return loop;
}

double K_P_limit(const SampledLoop &loop) {
    return last_that_holds({1e-3, 1e4}, 1e-7,
                           [&loop](double K_P) { return is_stable(with_K_P(loop, K_P)); });
}

SampledLoop firm_loop() {
    const device::DeviceDescription device = testing::phantom_1_0();
    SampledLoop loop;
    loop.drive.motor = device.motor[1];
    loop.device = device_load(device, 1);
    return loop;
}

/// The same loop in time, with Runge-Kutta steps instead of the matrix exponential.
class BruteForce {
public:
    explicit BruteForce(const SampledLoop &loop)
        : loop_(loop), held_V_(static_cast<std::size_t>(loop.drive.delay_periods), 0.0) {}

    /// The largest |θ| over a number of periods.
    double run(int periods) {
        double largest_rad = 0.0;
        for (int k = 0; k < periods; ++k) {
            const double e_W_V = tick_V();
            // Short against L/dR, 0.1 ms and more: the fifth order is below 1e-5 a period.
            const int steps = static_cast<int>(std::ceil(loop_.drive.period_s / 25e-6));
            for (int step = 0; step < steps; ++step) {
                advance(e_W_V, loop_.drive.period_s / steps);
            }
            largest_rad = std::max(largest_rad, std::abs(state_[0]));
        }
        return largest_rad;
    }

private:
    double tick_V() {
        const control::Tuning &tuning = loop_.drive.tuning;
        const double a = std::exp(-tuning.lambda_rad_per_s * loop_.drive.period_s);
        filtered_ = a * filtered_ + (1.0 - a) * (state_[0] - before_rad_) / loop_.drive.period_s;
        before_rad_ = state_[0];
        const double set_point = tuning.eta * state_[0]; // (17) with θ₀ = 0
        const double set_point_rate = tuning.eta * filtered_;
        held_V_.push_back(loop_.drive.motor.torque_constant_Nm_per_A * set_point_rate +
                          tuning.K_D_Vs_per_rad * (set_point_rate - filtered_) +
                          tuning.K_P_V_per_rad * (set_point - state_[0]));
        const double applied_V = held_V_.front();
        held_V_.pop_front();
        return applied_V;
    }

    [[nodiscard]] Vector3 rates(const Vector3 &x, double e_W_V) const {
        const device::MotorParameters &m = loop_.drive.motor;
        const double J =
            m.rotor_inertia_kg_m2 + loop_.device.inertia_kg_m2 + loop_.hand.inertia_kg_m2;
        const double b = loop_.device.damping_Nms_per_rad + loop_.hand.damping_Nms_per_rad;
        const double k = loop_.device.stiffness_Nm_per_rad + loop_.hand.stiffness_Nm_per_rad;
        const double k_T = m.torque_constant_Nm_per_A;
        return {x[1], (k_T * x[2] - b * x[1] - k * x[0]) / J,
                (e_W_V - loop_.drive.tuning.dR_Ohm * x[2] - k_T * x[1]) / m.inductance_H};
    }

    void advance(double e_W_V, double h) {
        const Vector3 k1 = rates(state_, e_W_V);
        const Vector3 k2 = rates(state_ + 0.5 * h * k1, e_W_V);
        const Vector3 k3 = rates(state_ + 0.5 * h * k2, e_W_V);
        const Vector3 k4 = rates(state_ + h * k3, e_W_V);
        state_ += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }

    SampledLoop loop_;
    Vector3 state_{1e-3, 0.1, 0.0}; ///< θ, θ̇, i
    double before_rad_ = 1e-3;
    double filtered_ = 0.0;
    std::deque<double> held_V_;
};

TEST(SampledLoop, AgreesWithASimulationOnBothSidesOfTheLine) {
    std::mt19937 random(4);
    const auto between = [&random](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    for (int i = 0; i < 24; ++i) {
        SampledLoop loop = firm_loop();
        loop.drive.tuning.dR_Ohm = between(0.1, 2.0);
        loop.drive.tuning.K_D_Vs_per_rad = between(0.0, 0.01);
        loop.drive.tuning.lambda_rad_per_s = between(300.0, 3000.0);
        loop.drive.tuning.eta = i % 3 == 0 ? between(0.0, 0.5) : 0.0;
        loop.drive.period_s = between(1e-4, 2e-3);
        loop.drive.delay_periods = i % 3;
        if (i % 2 == 0) {
            loop.hand = {between(0.0, 5e-5), between(0.0, 1e-4), between(0.0, 0.1)};
        }
        const double limit = K_P_limit(loop);
        ASSERT_GT(limit, 0.01) << "unstable without K_P: says nothing";
        ASSERT_LT(limit, 1e3);
        // 5 % from the limit the slowest mode changes by more than a factor 2 in 3000 periods.
        BruteForce below(with_K_P(loop, 0.95 * limit));
        const double below_at_first = below.run(500);
        EXPECT_LT(below.run(3000), 1.001 * below_at_first);
        EXPECT_LT(below.run(500), 0.5 * below_at_first) << "K_P " << 0.95 * limit;
        BruteForce above(with_K_P(loop, 1.05 * limit));
        const double above_at_first = above.run(500);
        above.run(3000);
        EXPECT_GT(above.run(500), 2.0 * above_at_first) << "K_P " << 1.05 * limit;
    }
}

/// With a winding much faster than the servo, torque follows voltage: k_T K_P/dR becomes a virtual
/// wall behind a zero-order hold, k_T²/dR a damper. Sampled exactly, a mass J with damping b makes
///
///   z² − (1 + p) z + p + (K/b) [ (T − τ(1 − p)) z + τ(1 − p) − pT ],   p = e^(−bT/J), τ = J/b,
///
/// whose roots lie within the circle (Jury) while K < b (1 − p)/(τ(1 − p) − pT) and while its value
/// at z = −1 is positive.
double wall_limit(double J, double b, double T) {
    const double p = std::exp(-b * T / J);
    const double tau = J / b;
    const double constant = tau * (1.0 - p) - p * T;
    const double at_one_pole = b * (1.0 - p) / constant;
    const double slope = T - tau * (1.0 - p) - constant;
    const double at_minus_one = slope > 0.0 ? 2.0 * b * (1.0 + p) / slope : at_one_pole;
    return std::min(at_one_pole, at_minus_one);
}

SampledLoop wall(double inertia_kg_m2, double damping_Nms_per_rad) {
    SampledLoop loop;
    loop.drive.motor = testing::phantom_1_0().motor[0];
    loop.drive.motor.resistance_Ohm = 2000.0;
    loop.drive.motor.inductance_H = 1e-6; // L/dR is a millionth of T
    loop.drive.motor.rotor_inertia_kg_m2 = inertia_kg_m2;
    loop.drive.tuning.dR_Ohm = 1000.0;
    loop.drive.tuning.K_D_Vs_per_rad = 0.0;
    loop.device.damping_Nms_per_rad = damping_Nms_per_rad;
    return loop;
}

double wall_stiffness_limit(const SampledLoop &loop) {
    const double per_volt = loop.drive.motor.torque_constant_Nm_per_A / loop.drive.tuning.dR_Ohm;
    return per_volt * last_that_holds({1e-6, 1e9}, 1e-7, [&loop](double K_P) {
               return is_stable(with_K_P(loop, K_P));
           });
}

TEST(SampledLoop, IsASampledVirtualWallWhenTheWindingIsFast) {
    for (const double J : {1e-6, 1e-5, 1e-4}) {
        for (const double b : {1e-4, 1e-3, 1e-2, 0.1}) {
            for (const double T : {1e-4, 1e-3}) {
                SampledLoop loop = wall(J, b);
                loop.drive.period_s = T;
                const double all_damping = b + device::series_damping_Nms_per_rad(
                                                   loop.drive.motor, loop.drive.tuning.dR_Ohm);
                const double truth = wall_limit(J, all_damping, T);
                // L/(dR T) is 1e-5 and less, and acts as a delay; a light wall is affected more.
                EXPECT_NEAR(wall_stiffness_limit(loop), truth, 1e-4 * truth)
                    << "J " << J << " b " << b << " T " << T;
            }
        }
    }
}

TEST(SampledLoop, HeavyWallReachesColgateAndSchenkelsLimit) {
    const SampledLoop loop = wall(0.1, 1e-3);
    const double b =
        1e-3 + device::series_damping_Nms_per_rad(loop.drive.motor, loop.drive.tuning.dR_Ohm);
    const double truth = 2.0 * b / loop.drive.period_s;
    // To bT/(6J) = 2e-6, and 4e-5 from the decay that `is_stable` requires of so slow a motion.
    EXPECT_NEAR(wall_stiffness_limit(loop), truth, 1e-4 * truth);
}

TEST(SampledLoop, FastServoMeetsRouthAndHurwitz) {
    // Without samples, L J s³ + (dR J + L b) s² + (dR b + k_T²) s + k_T K_P is stable while
    // (dR J + L b)(dR b + k_T²) > L J k_T K_P; without b while K_DC < K_L.
    SampledLoop loop = firm_loop();
    loop.drive.tuning.K_D_Vs_per_rad = 0.0;
    const device::MotorParameters &m = loop.drive.motor;
    const double k_T = m.torque_constant_Nm_per_A;
    const double J = m.rotor_inertia_kg_m2 + loop.device.inertia_kg_m2;
    for (const double b : {0.0, 1e-4}) {
        for (const double dR : {0.1, 0.5, 2.0}) {
            loop.device.damping_Nms_per_rad = b;
            loop.drive.tuning.dR_Ohm = dR;
            const double truth =
                (dR * J + m.inductance_H * b) * (dR * b + k_T * k_T) / (m.inductance_H * J * k_T);
            const auto miss = [&](double period_s) {
                loop.drive.period_s = period_s;
                return 1.0 - K_P_limit(loop) / truth;
            };
            const double coarse = miss(8e-6);
            // The hold is a delay of T/2: the limit is too low at first order.
            EXPECT_GT(coarse, 0.0);
            EXPECT_LT(coarse, 0.05);
            EXPECT_NEAR(std::log2(coarse / miss(4e-6)), 1.0, 0.1) << "b " << b << " dR " << dR;
        }
    }
}

TEST(SampledLoop, FreeSpaceMayRestAnywhereButNotMoveOn) {
    SampledLoop loop = firm_loop();
    loop.drive.tuning.eta = 1.0;
    const Eigen::VectorXcd eigenvalues = one_period_map(loop).eigenvalues();
    EXPECT_LT((eigenvalues.array() - 1.0).abs().minCoeff(), 1e-9); // round-off
    EXPECT_TRUE(is_stable(loop));
    loop.device.damping_Nms_per_rad = 0.0;
    EXPECT_FALSE(is_stable(loop));
    EXPECT_NEAR(largest_eigenvalue(loop), 1.0, 1e-12);
    // A hand's spring leaves only one place of rest.
    loop.hand = {1e-5, 1e-4, 0.01};
    EXPECT_TRUE(is_stable(loop));
}

} // namespace
} // namespace springdrive::loops

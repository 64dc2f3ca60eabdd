// Covers engine/lab/loops/linear_loop.cpp with one motor, and so tests/support/sampled_loop.h.
#include "tests/support/sampled_loop.h"

#include "base/bisection.h"
#include "tests/support/devices.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>

namespace springdrive::loops {
namespace {

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

TEST(SampledLoop, ADelayKeepsEveryHeldOutput) {
    SampledLoop loop = firm_loop();
    for (const int delay : {0, 1, 2, 5}) {
        loop.drive.delay_periods = delay;
        EXPECT_EQ(one_period_map(loop).rows(), 5 + delay);
        loop.drive.delay_periods = delay + 1e-3;
        EXPECT_EQ(one_period_map(loop).rows(), 5 + delay + 1);
        loop.drive.delay_periods = delay + 0.999;
        EXPECT_EQ(one_period_map(loop).rows(), 5 + delay + 1);
    }
}

TEST(DeviceLoad, IsTheTipMassSeenThroughTheTransmission) {
    const device::DeviceDescription device = testing::phantom_1_0();
    // 75 g at l₁ behind N is 1.2e-5; the data sheet says "below".
    const double l = device.geometry.upper_arm_m;
    const double N = device.geometry.transmission_ratio.y();
    const device::RotorLoad load = device_load(device, 1);
    EXPECT_LT(load.inertia_kg_m2, 0.075 * l * l / (N * N));
    EXPECT_GT(load.inertia_kg_m2, 0.2 * 0.075 * l * l / (N * N));
    EXPECT_EQ(load.stiffness_Nm_per_rad, 0.0);
}

} // namespace
} // namespace springdrive::loops

// Time simulation of one motor and its servo by Runge-Kutta steps: an independent reference that
// shares no code with predictions and simulation.
#pragma once

#include "device/core/phantom/kinematics.h"
#include "engine/lab/loops/stability_case.h"

#include <algorithm>
#include <cmath>
#include <deque>

namespace springdrive::testing {

/// A motor with an inertia of its own behind a spring drive, for a case with one hand:
///
///   L di/dt = e_W − dR i − k_T θ̇        J θ̈ = k_T i − b θ̇ − k θ
///   e_W = η k_T v − (1 − η)(K_D v + K_P θ), after d periods: where d is no whole number, e_W
///         changes within the period, and steps end there
class RungeKuttaLoop {
public:
    explicit RungeKuttaLoop(const loops::StabilityCase &which)
        : tuning_(which.tuning), motor_(which.device.motor[1]),
          dR_Ohm_(which.dR_Ohm(which.device.motor[1])), period_s_(which.period_s),
          load_(*which.rotor) {
        double whole = 0.0;
        fraction_ = std::modf(which.delay_periods, &whole);
        held_V_.assign(static_cast<std::size_t>(whole) + 1, 0.0);
        const double lever_m =
            device::motor_jacobian(which.device.geometry, which.q_rad).col(1).norm();
        const loops::Hand &hand = which.hands.front();
        load_.inertia_kg_m2 += hand.mass_kg * lever_m * lever_m;
        load_.damping_Nms_per_rad += hand.damping_Ns_per_m * lever_m * lever_m;
        load_.stiffness_Nm_per_rad += hand.stiffness_N_per_m * lever_m * lever_m;
        const double K_L = device::inductive_stiffness_Nm_per_rad(motor_);
        const double fastest_per_s =
            std::max(std::abs(dR_Ohm_) / motor_.inductance_H,
                     std::sqrt((K_L + load_.stiffness_Nm_per_rad) / load_.inertia_kg_m2) +
                         load_.damping_Nms_per_rad / load_.inertia_kg_m2);
        // A twentieth of the fastest mode's time constant: error (1/20)⁴/120 = 5e-8.
        steps_a_second_ = 20.0 * fastest_per_s;
    }

    /// The largest |θ̇| over `periods` periods.
    double run(int periods) {
        double largest = 0.0;
        for (int k = 0; k < periods; ++k) {
            tick();
            advance_by(fraction_ * period_s_, held_V_[0]);
            advance_by((1.0 - fraction_) * period_s_, held_V_[1]);
            held_V_.pop_front();
            largest = std::max(largest, std::abs(state_[1]));
        }
        return largest;
    }

    /// Whether the motion has decayed after many periods, by two comparisons.
    bool dies_out() {
        run(400); // initial transient
        double before = run(kBlock);
        for (int i = 0; i < 10; ++i) {
            const double now = run(kBlock);
            if (now > 30.0 * before || now < before / 30.0) {
                return now < before;
            }
            if (i == 9) {
                return now < before;
            }
        }
        return false;
    }

private:
    static constexpr int kBlock = 400;

    void tick() {
        const double a = std::exp(-tuning_.lambda_rad_per_s * period_s_);
        filtered_ = a * filtered_ + (1.0 - a) * (state_[0] - before_rad_) / period_s_;
        before_rad_ = state_[0];
        const double set_point = tuning_.eta * state_[0]; // (17) with θ₀ = 0
        const double set_point_rate = tuning_.eta * filtered_;
        held_V_.push_back(motor_.torque_constant_Nm_per_A * set_point_rate +
                          tuning_.K_D_Vs_per_rad * (set_point_rate - filtered_) +
                          tuning_.K_P_V_per_rad * (set_point - state_[0]));
    }

    [[nodiscard]] Vector3 rates(const Vector3 &x, double e_W_V) const {
        const double k_T = motor_.torque_constant_Nm_per_A;
        return {
            x[1],
            (k_T * x[2] - load_.damping_Nms_per_rad * x[1] - load_.stiffness_Nm_per_rad * x[0]) /
                load_.inertia_kg_m2,
            (e_W_V - dR_Ohm_ * x[2] - k_T * x[1]) / motor_.inductance_H};
    }

    void advance_by(double time_s, double e_W_V) {
        const int steps = static_cast<int>(std::ceil(steps_a_second_ * time_s));
        for (int step = 0; step < steps; ++step) {
            advance(e_W_V, time_s / steps);
        }
    }

    void advance(double e_W_V, double h) {
        const Vector3 k1 = rates(state_, e_W_V);
        const Vector3 k2 = rates(state_ + 0.5 * h * k1, e_W_V);
        const Vector3 k3 = rates(state_ + 0.5 * h * k2, e_W_V);
        const Vector3 k4 = rates(state_ + h * k3, e_W_V);
        state_ += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }

    control::Tuning tuning_;
    device::MotorParameters motor_;
    double dR_Ohm_;
    double period_s_;
    device::RotorLoad load_;
    double fraction_ = 0.0; ///< of d
    double steps_a_second_ = 0.0;
    Vector3 state_{1e-3, 0.1, 0.0}; ///< θ, θ̇, i
    double before_rad_ = 1e-3;
    double filtered_ = 0.0;
    std::deque<double> held_V_; ///< the active one first, then the pending ones
};

} // namespace springdrive::testing

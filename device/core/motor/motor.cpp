#include "device/core/motor/motor.h"

#include "base/bisection.h"

#include <algorithm>
#include <cmath>

namespace springdrive::device {

namespace {

/// A constant voltage behind a net resistance, as the winding sees it, (11).
struct Source {
    double voltage_V = 0.0;
    double net_resistance_Ohm = 0.0;
};

/// `start` holds the current at the beginning of the step, including its part proportional to the
/// rate.
CurrentStep behind(const MotorParameters &motor, const Source &source, const CurrentStep &start,
                   double step_s) {
    const WindingStep w = winding_step(motor, source.net_resistance_Ohm, step_s);
    const double k_T = motor.torque_constant_Nm_per_A;
    return {w.decay * start.end_A + w.gain_A_per_V * source.voltage_V,
            w.decay * start.end_As_per_rad - k_T * w.gain_A_per_V,
            w.mean_decay * start.end_A + w.mean_gain_A_per_V * source.voltage_V,
            w.mean_decay * start.end_As_per_rad - k_T * w.mean_gain_A_per_V};
}

CurrentStep behind(const MotorParameters &motor, const Source &source, const DriveState &now,
                   double step_s) {
    return behind(motor, source, CurrentStep{now.current_A, 0.0, 0.0, 0.0}, step_s);
}

CurrentStep at_once(const MotorParameters &motor, const Source &source) {
    const double end_A = source.voltage_V / source.net_resistance_Ohm;
    const double end_As_per_rad = -motor.torque_constant_Nm_per_A / source.net_resistance_Ohm;
    return {end_A, end_As_per_rad, end_A, end_As_per_rad};
}

/// The source that sustains the current limit at standstill, within the supply.
Source sustaining(const MotorParameters &motor, const DriveState &now, double current_A) {
    const double voltage_V = std::min(motor.supply_V, motor.peak_current_A * now.resistance_Ohm);
    return {std::copysign(voltage_V, current_A), now.resistance_Ohm};
}

/// A step behind one source and then another.
CurrentStep behind_both(const MotorParameters &motor, const DriveState &now, const Source &first,
                        double first_s, const Source &second, double second_s) {
    const CurrentStep before = behind(motor, first, now, first_s);
    const CurrentStep after = behind(motor, second, before, second_s);
    const double share = first_s / (first_s + second_s);
    return {after.end_A, after.end_As_per_rad, share * before.mean_A + (1.0 - share) * after.mean_A,
            share * before.mean_As_per_rad + (1.0 - share) * after.mean_As_per_rad};
}

/// Time within the step at which R̂ i + e_W reaches the supply, given that it exceeds it at the
/// end.
double time_to_rail_s(const MotorParameters &motor, const DriveState &now, const Source &free,
                      double cancelled_resistance_Ohm, double step_s) {
    const auto is_within = [&](double time_s) {
        const double current_A = behind(motor, free, now, time_s).end_at(now.rate_rad_per_s);
        const double e_A_V = cancelled_resistance_Ohm * current_A + free.voltage_V;
        return std::abs(e_A_V) <= motor.supply_V;
    };
    return bisect({0.0, step_s}, 40, is_within).fails_at; // to 1e-12 of the step
}

} // namespace

WindingStep winding_step(const MotorParameters &motor, double residual_resistance_Ohm,
                         double step_s) {
    const double x = -residual_resistance_Ohm * step_s / motor.inductance_H;
    // φ₂ loses half its digits to cancellation at |x| = 1e-8 and all at 1e-16; below 1e-2 its
    // series, truncated after x⁵, is exact to round-off (the next term is x⁶/40320 < 1e-16).
    const bool small = std::abs(x) < 1e-2;
    const double growth = std::expm1(x);
    const double phi1 = x == 0.0 ? 1.0 : growth / x;
    const double phi2 =
        small ? 1.0 / 2 +
                    x * (1.0 / 6 + x * (1.0 / 24 + x * (1.0 / 120 + x * (1.0 / 720 + x / 5040))))
              : (phi1 - 1.0) / x;
    const double h_over_L = step_s / motor.inductance_H;
    return {1.0 + growth, h_over_L * phi1, phi1, h_over_L * phi2};
}

CurrentStep spring_drive_step(const MotorParameters &motor, const DriveState &now, double e_W_V,
                              double cancelled_resistance_Ohm, double step_s) {
    const Source free{e_W_V, now.resistance_Ohm - cancelled_resistance_Ohm};
    const CurrentStep unlimited = behind(motor, free, now, step_s);
    if (!now.limited) {
        return unlimited;
    }
    const auto e_A_V = [&](double current_A) {
        return cancelled_resistance_Ohm * current_A + e_W_V;
    };
    const double first_V = e_A_V(now.current_A);
    if (std::abs(now.current_A) >= motor.peak_current_A && first_V * now.current_A > 0.0) {
        return behind(motor, sustaining(motor, now, now.current_A), now, step_s);
    }
    const double last_V = e_A_V(unlimited.end_at(now.rate_rad_per_s));
    const Source rail{
        std::copysign(motor.supply_V, std::abs(first_V) > motor.supply_V ? first_V : last_V),
        now.resistance_Ohm};
    if (std::abs(first_V) > motor.supply_V) {
        return behind(motor, rail, now, step_s);
    }
    if (std::abs(last_V) > motor.supply_V) {
        const double free_s = time_to_rail_s(motor, now, free, cancelled_resistance_Ohm, step_s);
        return behind_both(motor, now, free, free_s, rail, step_s - free_s);
    }
    return unlimited;
}

CurrentStep current_drive_step(const MotorParameters &motor, const DriveState &now,
                               double commanded_A, double bandwidth_rad_per_s, double step_s) {
    const double requested_A =
        now.limited ? std::clamp(commanded_A, -motor.peak_current_A, motor.peak_current_A)
                    : commanded_A;
    const double x = bandwidth_rad_per_s * step_s;
    const double gap_A = now.current_A - requested_A;
    const double end_A = requested_A + gap_A * std::exp(-x);
    const double mean_A = requested_A - gap_A * std::expm1(-x) / x;
    const double e_A_V = now.resistance_Ohm * mean_A +
                         motor.inductance_H * (end_A - now.current_A) / step_s +
                         motor.torque_constant_Nm_per_A * now.rate_rad_per_s;
    if (now.limited && std::abs(e_A_V) > motor.supply_V) {
        return behind(motor, {std::copysign(motor.supply_V, e_A_V), now.resistance_Ohm}, now,
                      step_s);
    }
    return {end_A, 0.0, mean_A, 0.0};
}

CurrentStep spring_drive_at_once(const MotorParameters &motor, const DriveState &now, double e_W_V,
                                 double cancelled_resistance_Ohm) {
    const double R = now.resistance_Ohm;
    const double dR = std::max(R - cancelled_resistance_Ohm, kMinResidualShare * R);
    const CurrentStep unlimited = at_once(motor, {e_W_V, dR});
    if (!now.limited) {
        return unlimited;
    }
    const double free_A = unlimited.end_at(now.rate_rad_per_s);
    const double e_A_V = (R - dR) * free_A + e_W_V;
    const CurrentStep supplied = std::abs(e_A_V) > motor.supply_V
                                     ? at_once(motor, {std::copysign(motor.supply_V, e_A_V), R})
                                     : unlimited;
    const double current_A = supplied.end_at(now.rate_rad_per_s);
    const bool driven_on = e_A_V * current_A > 0.0;
    return driven_on && std::abs(current_A) > motor.peak_current_A
               ? at_once(motor, sustaining(motor, now, current_A))
               : supplied;
}

CurrentStep current_drive_at_once(const MotorParameters &motor, const DriveState &now,
                                  double commanded_A) {
    if (!now.limited) {
        return {commanded_A, 0.0, commanded_A, 0.0};
    }
    const double requested_A = std::clamp(commanded_A, -motor.peak_current_A, motor.peak_current_A);
    const double e_A_V =
        now.resistance_Ohm * requested_A + motor.torque_constant_Nm_per_A * now.rate_rad_per_s;
    if (std::abs(e_A_V) > motor.supply_V) {
        return at_once(motor, {std::copysign(motor.supply_V, e_A_V), now.resistance_Ohm});
    }
    return {requested_A, 0.0, requested_A, 0.0};
}

} // namespace springdrive::device

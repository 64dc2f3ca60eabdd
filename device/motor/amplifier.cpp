#include "device/motor/amplifier.h"

#include <algorithm>
#include <cmath>

namespace springdrive {

namespace {

/// A winding behind a constant voltage and a net resistance, (11).
CurrentStep behind(const MotorParameters &motor, double voltage_V, double net_resistance_Ohm,
                   double current_A, double step_s) {
    const WindingStep w = winding_step(motor, net_resistance_Ohm, step_s);
    const double k_T = motor.torque_constant_Nm_per_A;
    return {w.decay * current_A + w.gain_A_per_V * voltage_V, -k_T * w.gain_A_per_V,
            w.mean_decay * current_A + w.mean_gain_A_per_V * voltage_V, -k_T * w.mean_gain_A_per_V};
}

} // namespace

CurrentStep spring_drive_step(const MotorParameters &motor, const DriveState &now, double e_W_V,
                              double cancelled_resistance_Ohm, double step_s) {
    const double e_A_V = cancelled_resistance_Ohm * now.current_A + e_W_V;
    const bool drives_on = e_A_V * now.current_A > 0.0;
    if (now.limited && std::abs(now.current_A) >= motor.peak_current_A && drives_on) {
        const double sustaining_V =
            std::min(motor.supply_V, motor.peak_current_A * now.resistance_Ohm);
        return behind(motor, std::copysign(sustaining_V, now.current_A), now.resistance_Ohm,
                      now.current_A, step_s);
    }
    if (now.limited && std::abs(e_A_V) > motor.supply_V) {
        return behind(motor, std::copysign(motor.supply_V, e_A_V), now.resistance_Ohm,
                      now.current_A, step_s);
    }
    return behind(motor, e_W_V, now.resistance_Ohm - cancelled_resistance_Ohm, now.current_A,
                  step_s);
}

CurrentStep current_drive_step(const MotorParameters &motor, const DriveState &now,
                               double commanded_A, double bandwidth_rad_per_s, double step_s) {
    const double wanted_A =
        now.limited ? std::clamp(commanded_A, -motor.peak_current_A, motor.peak_current_A)
                    : commanded_A;
    const double x = bandwidth_rad_per_s * step_s;
    const double gap_A = now.current_A - wanted_A;
    const double end_A = wanted_A + gap_A * std::exp(-x);
    const double mean_A = wanted_A - gap_A * std::expm1(-x) / x;
    const double e_A_V = now.resistance_Ohm * mean_A +
                         motor.inductance_H * (end_A - now.current_A) / step_s +
                         motor.torque_constant_Nm_per_A * now.rate_rad_per_s;
    if (now.limited && std::abs(e_A_V) > motor.supply_V) {
        return behind(motor, std::copysign(motor.supply_V, e_A_V), now.resistance_Ohm,
                      now.current_A, step_s);
    }
    return {end_A, 0.0, mean_A, 0.0};
}

} // namespace springdrive

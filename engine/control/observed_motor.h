// What is known of a motor when its command is computed: what the device file says, or what was
// observed of it.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"

#include <algorithm>
#include <array>

namespace springdrive::control {

/// An estimate and its standard deviation.
struct ResistanceEstimate {
    double resistance_Ohm = 0.0;
    double deviation_Ohm = 0.0;
};

/// Resistances are as the amplifier sees them, R/(1 + g).
struct ObservedMotor {
    ResistanceEstimate here; ///< R(T, θ) at the present angle
    ResistanceEstimate mean; ///< averaged over the commutator's angles
    double torque_constant_Nm_per_A = 0.0;
    double offset_A = 0.0; ///< of the current's sensor
    bool is_observed = false;
    bool is_trusted = true; ///< false: what was measured contradicts the file, or itself
};

using ObservedMotors = std::array<ObservedMotor, 3>;

/// What the file says, which is taken as exact.
[[nodiscard]] constexpr ObservedMotor motor_of_file(const device::MotorParameters &motor) {
    return {{motor.resistance_Ohm, 0.0},
            {motor.resistance_Ohm, 0.0},
            motor.torque_constant_Nm_per_A,
            0.0,
            false,
            true};
}

[[nodiscard]] constexpr ObservedMotors
motors_of_file(const std::array<device::MotorParameters, 3> &motor) {
    return {motor_of_file(motor[0]), motor_of_file(motor[1]), motor_of_file(motor[2])};
}

/// k_T of the three motors [N·m/A].
[[nodiscard]] inline Vector3 torque_constants(const ObservedMotors &motors) {
    return {motors[0].torque_constant_Nm_per_A, motors[1].torque_constant_Nm_per_A,
            motors[2].torque_constant_Nm_per_A};
}

/// Their currents without the sensors' offsets [A].
[[nodiscard]] inline Vector3 without_offsets(const Vector3 &measured_A,
                                             const ObservedMotors &motors) {
    return measured_A - Vector3(motors[0].offset_A, motors[1].offset_A, motors[2].offset_A);
}

/// An unknown R may be so many standard deviations lower than it is taken for.
inline constexpr double kHeldUpDeviations = 3.0;

/// The least dR [Ω] that may be asked for with what is known of R: in the coldest air, at any angle
/// and with a file that is wrong by a fifth, less could be an R̂ above R.
[[nodiscard]] constexpr double held_up_dR_Ohm(const ObservedMotor &motor) {
    return motor.is_observed
               ? kHeldUpDeviations * std::max(motor.here.deviation_Ohm, motor.mean.deviation_Ohm)
               : 0.0;
}

/// R̂ [Ω] for the requested dR (7).
[[nodiscard]] constexpr double cancelled_resistance_Ohm(const device::MotorParameters &file,
                                                        const ObservedMotor &motor, double dR_Ohm) {
    const double residual_Ohm = device::residual_resistance_Ohm(file, dR_Ohm);
    return std::max(0.0, motor.here.resistance_Ohm - std::max(residual_Ohm, held_up_dR_Ohm(motor)));
}

} // namespace springdrive::control

#include "base/degrees.h"
#include "device/core/motor/amplifier.h"
#include "engine/control/tuning.h"
#include "engine/lab/limits/method_limits/limit_trials.h"

#include <algorithm>
#include <cmath>

namespace springdrive::limits {

namespace {

/// Whether the simulated amplifier settles at the current of (11), i = (e_W − k_T θ̇)/dR.
bool settles(const device::MotorParameters &motor, double e_W_V, double rate_rad_per_s) {
    constexpr int kSteps = 2000;
    constexpr double kStep_s = 50e-6; // some 200 times L/dR in total
    constexpr double kOff_A = 1e-5;
    const double dR_Ohm = control::Tuning{}.dR_Ohm;
    device::DriveState now{motor.resistance_Ohm, 0.0, rate_rad_per_s, true};
    for (int i = 0; i < kSteps; ++i) {
        now.current_A =
            device::spring_drive_step(motor, now, e_W_V, motor.resistance_Ohm - dR_Ohm, kStep_s)
                .end_at(rate_rad_per_s);
    }
    const double wanted_A = (e_W_V - motor.torque_constant_Nm_per_A * rate_rad_per_s) / dR_Ohm;
    return std::abs(now.current_A - wanted_A) < kOff_A;
}

/// K_P (θ_Sd − θ)/dR reaches the peak current, or what the supply drives through R at standstill.
LimitTrial at_stall(const device::MotorParameters &motor) {
    const control::Tuning tuning;
    const double max_A = std::min(motor.peak_current_A, motor.supply_V / motor.resistance_Ohm);
    return {{kMotorMethod,
             "θ_Sd − θ above",
             "°",
             "tuning firm, rotor held: the amplifier is limited to " + with_unit(max_A, "A"),
             kDegreesPerRadian * max_A * tuning.dR_Ohm / tuning.K_P_V_per_rad,
             {},
             {}},
            1e-2,
            1e3,
            false,
            [=](double error_deg) {
                return settles(motor, tuning.K_P_V_per_rad * error_deg / kDegreesPerRadian, 0.0);
            }};
}

/// e_A = R̂ i + e_W reaches the supply at i = (e_W − k_T θ̇)/dR: the faster a rotor returns to its
/// set-point, the more of the supply the back-EMF takes.
LimitTrial returning(const device::MotorParameters &motor) {
    constexpr double kRate_rad_per_s = 100.0;
    const control::Tuning tuning;
    const double back_emf_V = motor.torque_constant_Nm_per_A * kRate_rad_per_s;
    const double damping_V = tuning.K_D_Vs_per_rad * kRate_rad_per_s;
    const double R_hat_Ohm = motor.resistance_Ohm - tuning.dR_Ohm;
    const double e_W_V =
        (motor.supply_V * tuning.dR_Ohm + R_hat_Ohm * back_emf_V) / motor.resistance_Ohm;
    return {{kMotorMethod,
             "θ_Sd − θ above",
             "°",
             "tuning firm, rotor returning at " + with_unit(kRate_rad_per_s, "rad/s") +
                 ": R̂ i + e_W reaches the supply of " + with_unit(motor.supply_V, "V"),
             kDegreesPerRadian * (e_W_V + damping_V) / tuning.K_P_V_per_rad,
             {},
             {}},
            kDegreesPerRadian * (back_emf_V + damping_V) / tuning.K_P_V_per_rad, // no current
            1e3,
            false,
            [=](double error_deg) {
                const double pull_V = tuning.K_P_V_per_rad * error_deg / kDegreesPerRadian;
                return settles(motor, pull_V - damping_V, kRate_rad_per_s);
            }};
}

} // namespace

std::vector<LimitTrial> amplifier_trials(const device::DeviceDescription &device) {
    return {at_stall(device.motor[1]), returning(device.motor[1])};
}

} // namespace springdrive::limits

// Quantities derived from a tuning, which the tuning panel shows beside the sliders.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"
#include "device/core/motor/motor.h"
#include "engine/control/tuning.h"
#include "engine/control/velocity_filter.h"

#include <array>
#include <cmath>
#include <optional>

namespace springdrive::control {

/// The coupling K_θ between one rotor and its set-point.
struct Coupling {
    double K_L_Nm_per_rad = 0.0;      ///< inductive stiffness k_T²/L (4)
    double K_DC_Nm_per_rad = 0.0;     ///< static stiffness k_T K_P/dR (13)
    double K_HF_Nm_per_rad = 0.0;     ///< high-frequency stiffness k_T²/L (14)
    double B_dR_Nms_per_rad = 0.0;    ///< residual series damper k_T²/dR (8)
    double loop_lag_s = 0.0;          ///< τ, see `loop_lag_s`
    double added_inertia_kg_m2 = 0.0; ///< k_T² τ/dR, at the rotor in free space
};

/// τ = T (a/(1 − a) + 1 + d) with a = e^(−λT): the whole lag of the loop, which is felt in free
/// space.
[[nodiscard]] inline double loop_lag_s(double lambda_rad_per_s, double period_s,
                                       double delay_periods) {
    const double a = velocity_filter_pole(lambda_rad_per_s, period_s);
    return period_s * (a / (1.0 - a) + 1.0 + delay_periods);
}

/// The λ with that lag; nothing where it is not above T (1 + d), which no filter reaches.
[[nodiscard]] inline std::optional<double> lambda_of_lag_rad_per_s(double lag_s, double period_s,
                                                                   double delay_periods) {
    const double of_filter = lag_s / period_s - 1.0 - delay_periods; // a/(1 − a)
    if (!(of_filter > 0.0)) {
        return std::nullopt;
    }
    return std::log1p(1.0 / of_filter) / period_s;
}

/// @param period_s       T, the servo period
/// @param delay_periods  d, from reading θ to applying e_W
[[nodiscard]] inline Coupling coupling(const device::MotorParameters &motor, const Tuning &tuning,
                                       double period_s, double delay_periods) {
    Coupling c;
    c.K_L_Nm_per_rad = device::inductive_stiffness_Nm_per_rad(motor);
    const double dR_Ohm = device::residual_resistance_Ohm(motor, tuning.dR_Ohm);
    c.K_DC_Nm_per_rad =
        device::static_stiffness_Nm_per_rad(motor, tuning.K_P_V_per_rad, tuning.dR_Ohm);
    c.K_HF_Nm_per_rad = c.K_L_Nm_per_rad;
    c.B_dR_Nms_per_rad = device::series_damping_Nms_per_rad(motor, dR_Ohm);
    c.loop_lag_s = control::loop_lag_s(tuning.lambda_rad_per_s, period_s, delay_periods);
    c.added_inertia_kg_m2 = c.B_dR_Nms_per_rad * c.loop_lag_s;
    return c;
}

/// K_DC (13) of each motor [N·m/rad]. RT-safe.
[[nodiscard]] inline Vector3
static_stiffness_Nm_per_rad(const std::array<device::MotorParameters, 3> &motor,
                            const Tuning &tuning) noexcept {
    const auto of = [&tuning](const device::MotorParameters &each) {
        return device::static_stiffness_Nm_per_rad(each, tuning.K_P_V_per_rad, tuning.dR_Ohm);
    };
    return {of(motor[0]), of(motor[1]), of(motor[2])};
}

/// k̄: the mean of K_DC over the motors [N·m/rad].
[[nodiscard]] inline double
mean_static_stiffness_Nm_per_rad(const device::DeviceDescription &device, const Tuning &tuning) {
    const Vector3 K_DC = static_stiffness_Nm_per_rad(device.motor, tuning);
    return (K_DC[0] + K_DC[1] + K_DC[2]) / 3.0;
}

/// Static tip stiffness of the transpose map (27) with η: (1 − η) α K_DC [N/m].
[[nodiscard]] inline double tip_stiffness_N_per_m(const Coupling &c, double alpha_rad2_per_m2,
                                                  double eta) {
    return (1.0 - eta) * alpha_rad2_per_m2 * c.K_DC_Nm_per_rad;
}

} // namespace springdrive::control

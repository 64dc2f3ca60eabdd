// A motor with a locked rotor behind a spring drive: its static current (11) warms it, and a guard
// limits its R̂.
#pragma once

#include "device/core/motor/motor.h"
#include "device/core/motor/winding_guard.h"
#include "device/core/motor/winding_temperature.h"

#include <algorithm>

namespace springdrive::limits {

class HeldMotor {
public:
    /// Winding and housing start at the air's temperature.
    /// @param theta_rad  the rotor's angle
    /// @param step_s duration of each `advance`
    HeldMotor(const device::MotorParameters &motor, const device::AmplifierParameters &amplifier,
              double theta_rad, double ambient_C, double step_s)
        : motor_(motor), theta_rad_(theta_rad), temperature_(motor.thermal, ambient_C, step_s),
          guard_(motor, amplifier.max_cancelled_Ohm, step_s) {}

    /// Sets R̂ = R(T, θ) − dR (7), as the operator does.
    void tune(double dR_Ohm) {
        R_hat_asked_Ohm_ = resistance_Ohm() - device::residual_resistance_Ohm(motor_, dR_Ohm);
    }
    void apply(double e_W_V) { e_W_V_ = e_W_V; }

    /// One step with the current at its start.
    void advance() {
        const double current = current_A();
        temperature_.update(current * current * resistance_Ohm());
        guard_.update(current);
    }

    [[nodiscard]] double resistance_Ohm() const {
        return device::winding_resistance_Ohm(motor_, temperature_.winding_C(), theta_rad_);
    }
    [[nodiscard]] double R_hat_asked_Ohm() const { return R_hat_asked_Ohm_; }
    [[nodiscard]] double R_hat_allowed_Ohm() const {
        return std::min(R_hat_asked_Ohm_, guard_.max_cancelled_Ohm());
    }
    [[nodiscard]] double dR_Ohm() const { return resistance_Ohm() - R_hat_allowed_Ohm(); }
    [[nodiscard]] double dR_unlimited_Ohm() const { return resistance_Ohm() - R_hat_asked_Ohm_; }
    [[nodiscard]] double min_dR_Ohm() const {
        return device::min_resistance_Ohm(motor_, winding_C()) - R_hat_allowed_Ohm();
    }
    [[nodiscard]] double min_dR_unlimited_Ohm() const {
        return device::min_resistance_Ohm(motor_, winding_C()) - R_hat_asked_Ohm_;
    }
    /// (11) at rest, with an unlimited supply.
    [[nodiscard]] double asked_current_A() const { return e_W_V_ / dR_Ohm(); }
    /// The same, limited to what the supply drives through R.
    [[nodiscard]] double current_A() const {
        const double rail_A = motor_.supply_V / resistance_Ohm();
        return std::clamp(asked_current_A(), -rail_A, rail_A);
    }
    [[nodiscard]] double winding_C() const { return temperature_.winding_C(); }
    [[nodiscard]] bool too_hot() const { return guard_.max_C() > motor_.thermal.max_winding_C; }
    [[nodiscard]] const device::MotorParameters &parameters() const { return motor_; }

private:
    device::MotorParameters motor_;
    double theta_rad_;
    device::WindingTemperature temperature_;
    device::WindingGuard guard_;
    double R_hat_asked_Ohm_ = 0.0;
    double e_W_V_ = 0.0;
};

} // namespace springdrive::limits

#include "engine/lab/limits/thermal_hold.h"

#include "base/input_error.h"
#include "device/core/motor/motor.h"
#include "device/core/motor/winding_guard.h"
#include "device/core/motor/winding_temperature.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/force_direction.h"
#include "engine/control/motion_control.h"
#include "engine/lab/rig/scenario/scenarios.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace springdrive::limits {

namespace {

constexpr double kMaxThermalStep_s = 0.01;
constexpr double kMaxHold_s = 86400.0;
constexpr int kMaxRows = 100000;
constexpr double kMax_K_P_V_per_rad = 1e6; ///< far beyond any stable one

/// A motor with a locked rotor behind a spring drive: its static current (11) warms it, and a guard
/// limits its R̂.
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

[[nodiscard]] Vector3 of_each(const std::array<HeldMotor, 3> &motors,
                              double (HeldMotor::*value)() const) {
    return {(motors[0].*value)(), (motors[1].*value)(), (motors[2].*value)()};
}

/// The device locked at one configuration.
class HeldDevice {
public:
    HeldDevice(const device::DeviceDescription &device, const ThermalHoldOptions &options,
               double step_s)
        : k_T_(control::torque_constants(device)), options_(options), step_s_(step_s),
          normal_(options.direction.normalized()),
          theta_rad_(device::motor_from_joint(device.geometry, options.q_rad)),
          J_(device::motor_jacobian(device.geometry, options.q_rad)),
          motors_({motor(device, 0), motor(device, 1), motor(device, 2)}) {
        tune();
        pull(theta_gap_rad(control::relative_stiffness(device)));
        check_currents();
    }

    void release_hot() {
        tune();
        pull(Vector3::Zero());
        phase_ = ThermalPhase::cool;
    }

    void advance() {
        for (HeldMotor &motor : motors_) {
            motor.advance();
        }
        ++steps_;
    }

    [[nodiscard]] bool too_hot() const {
        return std::any_of(motors_.begin(), motors_.end(),
                           [](const HeldMotor &motor) { return motor.too_hot(); });
    }

    [[nodiscard]] ThermalRow row() const;

private:
    [[nodiscard]] HeldMotor motor(const device::DeviceDescription &device, std::size_t j) const {
        return {device.motor[j], device.amplifier, theta_rad_[static_cast<Eigen::Index>(j)],
                options_.ambient_C, step_s_};
    }
    void tune() {
        for (HeldMotor &motor : motors_) {
            motor.tune(options_.tuning.dR_Ohm);
        }
    }

    [[nodiscard]] Vector3 static_stiffness_Nm_per_rad() const {
        return options_.tuning.K_P_V_per_rad *
               k_T_.cwiseQuotient(of_each(motors_, &HeldMotor::dR_Ohm));
    }
    [[nodiscard]] Vector3 tip_force_N() const {
        return control::static_tip_force(J_, k_T_, of_each(motors_, &HeldMotor::current_A));
    }

    /// θ_Sd − θ of (23) for a set-point along the normal, at the distance at which the tip renders
    /// the requested force. That distance is proportional to 1/α and does not affect locked motors.
    [[nodiscard]] Vector3 theta_gap_rad(const Vector3 &W) const {
        control::Configuration now;
        now.J = J_;
        control::TipSetPoint target;
        target.x_Sd_m = normal_;
        const Vector3 gap_rad =
            control::transpose_map(now, target, control::alpha_bound(J_, W), W).theta_Sd_rad;
        const double force_N =
            control::static_tip_force(J_, static_stiffness_Nm_per_rad(), gap_rad).norm();
        if (!(std::isfinite(force_N) && force_N > 0.0)) {
            throw InputError("the linkage is singular at this q and renders no force; choose "
                             "another configuration");
        }
        return options_.force_N / force_N * gap_rad;
    }

    /// (10) with everything at rest.
    void pull(const Vector3 &theta_gap_rad) {
        for (std::size_t j = 0; j < motors_.size(); ++j) {
            motors_[j].apply(options_.tuning.K_P_V_per_rad *
                             theta_gap_rad[static_cast<Eigen::Index>(j)]);
        }
    }

    void check_currents() const;

    Vector3 k_T_;
    ThermalHoldOptions options_;
    double step_s_;
    Vector3 normal_;
    Vector3 theta_rad_;
    Matrix3 J_;
    std::array<HeldMotor, 3> motors_;
    ThermalPhase phase_ = ThermalPhase::hold;
    long steps_ = 0;
};

/// The start is the most demanding moment for a motor: from then on dR only rises, and the current
/// falls.
void HeldDevice::check_currents() const {
    for (std::size_t j = 0; j < motors_.size(); ++j) {
        const device::MotorParameters &motor = motors_[j].parameters();
        const double current_A = std::abs(motors_[j].asked_current_A());
        const double limit_A =
            std::min(motor.peak_current_A, motor.supply_V / motors_[j].resistance_Ohm());
        if (!(current_A <= limit_A)) {
            throw InputError(fmt::format(
                "a hold of {:.3g} N needs {:.3g} A of motor {}, whose peak current and supply "
                "allow {:.3g} A; hold at most {:.3g} N",
                options_.force_N, current_A, j + 1, limit_A,
                options_.force_N * limit_A / current_A));
        }
    }
}

ThermalRow HeldDevice::row() const {
    ThermalRow row;
    row.time_s = static_cast<double>(steps_) * step_s_;
    row.phase = phase_;
    row.winding_C = of_each(motors_, &HeldMotor::winding_C);
    row.R_hat_asked_Ohm = of_each(motors_, &HeldMotor::R_hat_asked_Ohm);
    row.R_hat_allowed_Ohm = of_each(motors_, &HeldMotor::R_hat_allowed_Ohm);
    row.dR_unlimited_Ohm = of_each(motors_, &HeldMotor::dR_unlimited_Ohm);
    row.dR_Ohm = of_each(motors_, &HeldMotor::dR_Ohm);
    row.min_dR_unlimited_Ohm = of_each(motors_, &HeldMotor::min_dR_unlimited_Ohm);
    row.min_dR_Ohm = of_each(motors_, &HeldMotor::min_dR_Ohm);
    row.K_DC_Nm_per_rad = static_stiffness_Nm_per_rad();
    const Vector3 force_N = tip_force_N();
    row.tip_force_N = force_N.norm();
    row.direction_error_rad = control::direction_error_rad(force_N, normal_);
    double fastest_per_s = 0.0;
    for (const HeldMotor &motor : motors_) {
        fastest_per_s = std::max(fastest_per_s,
                                 -motor.min_dR_unlimited_Ohm() / motor.parameters().inductance_H);
    }
    if (fastest_per_s > 0.0) {
        row.growth_time_s = 1.0 / fastest_per_s;
    }
    row.tripped = too_hot();
    return row;
}

[[noreturn]] void refuse(const char *what, double value, const char *unit, const char *range,
                         double minimum, const char *range_end, double maximum) {
    throw InputError(fmt::format("thermal hold: {} is {:g}{}; it must be {}{:g}{}{:g}{}", what,
                                 value, unit, range, minimum, range_end, maximum, unit));
}

void check_range(const char *what, double value, double minimum, double maximum, const char *unit) {
    if (!(value >= minimum && value <= maximum)) { // a NaN too
        refuse(what, value, unit, "from ", minimum, " to ", maximum);
    }
}

void check_positive(const char *what, double value, double maximum, const char *unit) {
    if (!(value > 0.0 && value <= maximum)) {
        refuse(what, value, unit, "above ", 0.0, " and at most ", maximum);
    }
}

void check(const device::DeviceDescription &device, const ThermalHoldOptions &options) {
    check_positive("the force", options.force_N, device.limits.tip_force_N, " N");
    check_positive("the time", options.seconds, kMaxHold_s, " s");
    check_range("the number of rows", options.rows, 2, kMaxRows, "");
    check_positive("K_P", options.tuning.K_P_V_per_rad, kMax_K_P_V_per_rad, " V/rad");
    check_range("the air", options.ambient_C, device::kColdestAir_C, device::kWarmestAir_C, " °C");
    rig::check_configuration(device, options.q_rad);
    if (!(options.direction.allFinite() && options.direction.norm() > 0.0)) {
        throw InputError("thermal hold: the direction must be finite and have a length");
    }
}

} // namespace

std::vector<ThermalRow> thermal_hold(const device::DeviceDescription &device,
                                     const ThermalHoldOptions &options) {
    check(device, options);
    const double span_s = options.seconds / (options.rows - 1);
    const long steps_a_row = std::lround(std::max(1.0, std::ceil(span_s / kMaxThermalStep_s)));
    HeldDevice held(device, options, span_s / static_cast<double>(steps_a_row));
    std::vector<ThermalRow> rows;
    rows.reserve(2 * static_cast<std::size_t>(options.rows));
    for (const ThermalPhase phase : {ThermalPhase::hold, ThermalPhase::cool}) {
        if (phase == ThermalPhase::cool) {
            held.release_hot();
        }
        rows.push_back(held.row());
        for (int row = 1; row < options.rows; ++row) {
            for (long step = 0; step < steps_a_row && !held.too_hot(); ++step) {
                held.advance();
            }
            rows.push_back(held.row());
            if (rows.back().tripped) {
                return rows;
            }
        }
    }
    return rows;
}

} // namespace springdrive::limits

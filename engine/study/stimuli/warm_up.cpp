#include "engine/study/stimuli/warm_up.h"

#include "device/core/phantom/kinematics.h"
#include "engine/control/rendered_force.h"

#include <algorithm>
#include <cmath>

namespace springdrive::study {

namespace {

/// Below the monitor's limit of temperature, which trips by its upper bound [K].
constexpr double kBelowLimit_K = 5.0;

double winding_J_per_K(const device::ThermalParameters &thermal) {
    return thermal.winding_time_s / thermal.winding_housing_K_per_W;
}

double housing_J_per_K(const device::ThermalParameters &thermal) {
    return thermal.motor_time_s / thermal.housing_ambient_K_per_W;
}

Vector3 towards(const Vector3 &from, const Vector3 &to, double most) {
    return from + (to - from).cwiseMax(-most).cwiseMin(most);
}

/// R̂ of nothing, as far as a tuning can say it.
double max_dR_Ohm(const device::DeviceDescription &device) {
    double R_Ohm = 0.0;
    for (const device::MotorParameters &motor : device.motor) {
        R_Ohm = std::max(R_Ohm, motor.resistance_Ohm);
    }
    const auto *const dR = std::ranges::find(control::kParameters, &control::Tuning::dR_Ohm,
                                             &control::Parameter::value);
    return std::min(R_Ohm, dR->maximum);
}

} // namespace

double meeting_C(const device::ThermalParameters &thermal, double winding_C,
                 double housing_C) noexcept {
    const double C_w = winding_J_per_K(thermal);
    const double C_h = housing_J_per_K(thermal);
    return (C_w * winding_C + C_h * housing_C) / (C_w + C_h);
}

Vector3 warming_current_A(const device::DeviceDescription &device,
                          const servo::SafetyLimits &limits, const Vector3 &theta_rad) noexcept {
    Vector3 current_A;
    Vector3 k_T;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const device::MotorParameters &motor = device.motor[static_cast<std::size_t>(j)];
        k_T[j] = motor.torque_constant_Nm_per_A;
        current_A[j] =
            std::min(WarmUp::kCurrentShare * std::min(motor.peak_current_A, limits.current_A),
                     WarmUp::kVoltageShare * std::min(motor.supply_V, limits.voltage_V) /
                         motor.resistance_Ohm);
    }
    const Matrix3 J = device::motor_jacobian(device.geometry,
                                             device::joint_from_motor(device.geometry, theta_rad));
    const double force_N = control::static_tip_force(J, k_T, current_A).norm();
    const double share = WarmUp::kForceShare * limits.tip_force_N / force_N;
    return std::isfinite(force_N) ? Vector3(std::min(1.0, share) * current_A) : Vector3::Zero();
}

PredictedHeating predicted_heating(const device::MotorParameters &motor, const WindingBand &band,
                                   double current_A, double step_s) {
    PredictedHeating found{0.0, {motor.thermal, band.air_C, step_s}};
    device::WindingTemperature &now = found.temperature;
    while (meeting_C(motor.thermal, now.winding_C(), now.housing_C()) < WarmUp::warm_C(band) &&
           found.duration_s < WarmUp::kMax_s) {
        const double share =
            std::clamp((WarmUp::ceiling_C(band) - now.winding_C()) / WarmUp::kSoft_K, 0.0, 1.0);
        const double R_Ohm = device::max_resistance_Ohm(motor, now.winding_C());
        now.update(0.5 * share * R_Ohm * current_A * current_A);
        found.duration_s += step_s;
    }
    return found;
}

WarmUp::WarmUp(const device::DeviceDescription &device, const WindingBand &band, double period_s)
    : device_(device), band_(band), period_s_(period_s) {}

bool WarmUp::is_needed(const WindingBand &band, const Vector3 &winding_C) noexcept {
    return !(winding_C.minCoeff() >= band.from_C && winding_C.maxCoeff() <= band.to_C);
}

/// At first as warm as its winding, which without a current it soon is.
void WarmUp::follow_housings(const Vector3 &winding_C) noexcept {
    if (!has_housings_) {
        housing_C_ = winding_C;
        has_housings_ = true;
    }
    for (Eigen::Index j = 0; j < 3; ++j) {
        const device::ThermalParameters &thermal =
            device_.motor[static_cast<std::size_t>(j)].thermal;
        const double heat_W = (winding_C[j] - housing_C_[j]) / thermal.winding_housing_K_per_W -
                              (housing_C_[j] - band_.air_C) / thermal.housing_ambient_K_per_W;
        housing_C_[j] += period_s_ * heat_W / housing_J_per_K(thermal);
    }
}

/// Warm is what lacks nothing.
double WarmUp::lacking_K(Eigen::Index motor, double winding_C) const noexcept {
    const device::ThermalParameters &thermal =
        device_.motor[static_cast<std::size_t>(motor)].thermal;
    return warm_C(band_) - meeting_C(thermal, winding_C, housing_C_[motor]);
}

/// Of the most that it may have.
double WarmUp::heat_share(Eigen::Index motor, const servo::ServoSample &last) const noexcept {
    const auto index = static_cast<std::size_t>(motor);
    const double below_ceiling_K = ceiling_C(band_) - estimated_windings_C(last)[motor];
    const double limit_C =
        std::min(device_.motor[index].thermal.max_winding_C, last.limits.winding_C);
    const double below_limit_K = limit_C - kBelowLimit_K - last.winding[index].max_C;
    return std::clamp(std::min(below_ceiling_K, below_limit_K) / kSoft_K, 0.0, 1.0);
}

Vector3 WarmUp::requested_A(const servo::ServoSample &last, const Vector3 &most_A,
                            bool is_allowed) const noexcept {
    Vector3 requested_A = Vector3::Zero();
    for (Eigen::Index j = 0; j < 3 && is_allowed; ++j) {
        if (!has_warmed_[static_cast<std::size_t>(j)]) {
            requested_A[j] = std::sqrt(heat_share(j, last)) * most_A[j];
        }
    }
    return requested_A;
}

void WarmUp::proceed(const servo::ServoSample &last) noexcept {
    const Vector3 winding_C = estimated_windings_C(last);
    follow_housings(winding_C);
    const bool is_running = last.safety.state == servo::SafetyState::running;
    if (phase_ == WarmUpPhase::waiting && is_running && !last.contact.touching) {
        phase_ = WarmUpPhase::heating;
        for (Eigen::Index j = 0; j < 3; ++j) {
            has_warmed_[static_cast<std::size_t>(j)] =
                winding_C[j] >= band_.from_C && lacking_K(j, winding_C[j]) <= 0.0;
        }
    }
    off_band_K_ =
        std::max({0.0, band_.from_C - winding_C.minCoeff(), winding_C.maxCoeff() - band_.to_C});
    if (phase_ == WarmUpPhase::heating) {
        bool have_all = true;
        for (Eigen::Index j = 0; j < 3; ++j) {
            bool &has = has_warmed_[static_cast<std::size_t>(j)];
            const double missing_K = lacking_K(j, winding_C[j]);
            has = has || missing_K <= 0.0;
            have_all = have_all && has;
            off_band_K_ = has ? off_band_K_ : std::max(off_band_K_, missing_K);
        }
        if (have_all) {
            phase_ = WarmUpPhase::fading;
        }
    }
    const bool is_quiet = amplitude_A_.isZero(0.0) && has_asked_dR(last);
    if (phase_ == WarmUpPhase::fading && is_quiet && !is_needed(band_, winding_C)) {
        phase_ = WarmUpPhase::done;
    }
}

Vector3 WarmUp::voltage_V(const servo::ServoSample &last) noexcept {
    sign_ = -sign_;
    Vector3 voltage_V;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const double dR_Ohm = last.motor[static_cast<std::size_t>(j)].here.resistance_Ohm -
                              last.command.cancelled_resistance_Ohm[j];
        voltage_V[j] = sign_ * dR_Ohm * amplitude_A_[j];
    }
    return voltage_V;
}

void WarmUp::update(const servo::ServoSample &last, servo::LawInputs &inputs) noexcept {
    if (is_over()) {
        return;
    }
    if (!dR_before_Ohm_) {
        dR_before_Ohm_ = requested_dR_Ohm_ = inputs.tuning.dR_Ohm;
    }
    elapsed_s_ += period_s_;
    proceed(last);
    if (last.safety.state == servo::SafetyState::tripped) {
        failure_ = WarmUpFailure::tripped;
    } else if (!is_over() && elapsed_s_ > kMax_s) {
        failure_ = WarmUpFailure::too_long;
    }
    if (failure_ != WarmUpFailure::none) {
        phase_ = WarmUpPhase::failed;
    }
    const bool is_heating = phase_ == WarmUpPhase::heating;
    const Vector3 most_A = warming_current_A(device_, last.limits, last.theta_rad);
    const bool is_allowed = is_heating && !last.contact.touching &&
                            last.safety.state == servo::SafetyState::running && has_asked_dR(last);
    amplitude_A_ = is_over() ? Vector3(Vector3::Zero())
                             : towards(amplitude_A_, requested_A(last, most_A, is_allowed),
                                       most_A.maxCoeff() * period_s_ / kRamp_s);
    requested_dR_Ohm_ =
        is_heating || !amplitude_A_.isZero(0.0) ? max_dR_Ohm(device_) : *dR_before_Ohm_;
    inputs.tuning.dR_Ohm = requested_dR_Ohm_;
    inputs.excitation_V = voltage_V(last);
}

} // namespace springdrive::study

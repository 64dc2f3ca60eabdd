#include "engine/servo/bumpless_transfer.h"

#include "engine/control/tuning.h"

#include <algorithm>
#include <cmath>

namespace springdrive::servo {

namespace {

/// A parameter approaches its new value with this time constant, and reaches it when the difference
/// is within this share of its range.
constexpr double kTuningGlide_s = 0.05;
constexpr double kTuningArrived = 1e-6;

} // namespace

double max_resistance_change_Ohm_per_s(const device::DeviceDescription &device) {
    double peak_A = 0.0;
    for (const device::MotorParameters &motor : device.motor) {
        peak_A = std::max(peak_A, motor.peak_current_A);
    }
    return kMaxChange_V_per_s / peak_A;
}

BumplessTransfer::BumplessTransfer(const device::DeviceDescription &device, double period_s)
    : supply_V_(device.motor[0].supply_V, device.motor[1].supply_V, device.motor[2].supply_V),
      max_dR_change_Ohm_per_s_(max_resistance_change_Ohm_per_s(device)), period_s_(period_s) {}

void BumplessTransfer::set_period(double period_s) noexcept { period_s_ = period_s; }

void BumplessTransfer::approach(const LawSettings &requested, bool is_felt) noexcept {
    before_ = active_;
    active_ = requested;
    if (!is_felt) {
        return;
    }
    const double share = -std::expm1(-period_s_ / kTuningGlide_s);
    for (const control::Parameter &parameter : control::kParameters) {
        const double value = before_.tuning.*parameter.value;
        const double gap = requested.tuning.*parameter.value - value;
        if (std::abs(gap) >= kTuningArrived * (parameter.maximum - parameter.minimum)) {
            active_.tuning.*parameter.value = value + share * gap;
        }
    }
    const double step_Ohm = max_dR_change_Ohm_per_s_ * period_s_;
    const double dR_before_Ohm = before_.tuning.dR_Ohm;
    active_.tuning.dR_Ohm =
        std::clamp(active_.tuning.dR_Ohm, dR_before_Ohm - step_Ohm, dR_before_Ohm + step_Ohm);
}

void BumplessTransfer::carry(const Vector3 &e_W_V, const std::optional<Vector3> &unchanged_V,
                             bool scene_is_new, bool is_felt) noexcept {
    if (!is_felt) {
        transfer_offset_V_.setZero();
    } else {
        if (scene_is_new) {
            transfer_offset_V_ = last_e_W_V_ - e_W_V;
        } else if (unchanged_V) {
            // The old command counts only within the supply, the new one in full.
            transfer_offset_V_ = within_supply(*unchanged_V + transfer_offset_V_) - e_W_V;
        }
        const Vector3 bound_V = Vector3::Constant(kMaxChange_V_per_s * period_s_);
        transfer_offset_V_ -= transfer_offset_V_.cwiseMax(-bound_V).cwiseMin(bound_V);
    }
    last_e_W_V_ = within_supply(e_W_V + transfer_offset_V_);
}

Vector3 BumplessTransfer::within_supply(const Vector3 &e_W_V) const noexcept {
    return e_W_V.cwiseMax(-supply_V_).cwiseMin(supply_V_);
}

} // namespace springdrive::servo

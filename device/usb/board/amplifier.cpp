#include "device/usb/board/amplifier.h"

namespace springdrive::board {

namespace {

float limited(float value, float lower, float upper) {
    return value < lower ? lower : value > upper ? upper : value;
}

/// 1 − e^(−x) for x ≥ 0, by a Padé approximation of e^(−x/8), raised to the eighth power: to 1e-6
/// up to x = 4, without the library's expf.
float decay_share(float x) {
    const float z = (x < 40.0F ? x : 40.0F) / 8.0F;
    const float eighth = (12.0F - 6.0F * z + z * z) / (12.0F + 6.0F * z + z * z);
    const float quarter = eighth * eighth;
    const float half = quarter * quarter;
    return 1.0F - half * half;
}

} // namespace

Amplifier::Amplifier(const BoardSettings &settings)
    : rate_hz_(static_cast<float>(settings.loop_rate_hz)),
      slope_share_(decay_share(settings.lead_bandwidth_rad_per_s * settings.loop_period_s())),
      older_share_(limited(settings.actuation_lag_periods - 0.5F, 0.0F, 1.0F)),
      limit_A_(settings.current_limit_A * (1.0F - settings.gain_tolerance)) {
    for (std::size_t i = 0; i < kChannels; ++i) {
        const WindingSettings &winding = settings.winding[i];
        winding_[i] = {winding.resistance_Ohm, winding.inductance_H,
                       0.5F * winding.inductance_H * rate_hz_,
                       older_share_ * settings.loop_period_s() / winding.inductance_H};
    }
}

Triple Amplifier::limited_V(Triple voltage_V, float largest_V, std::uint8_t &acting) const {
    float highest_V = 0.0F;
    for (const float channel_V : voltage_V) {
        highest_V = magnitude(channel_V) > highest_V ? magnitude(channel_V) : highest_V;
    }
    if (highest_V > largest_V) {
        acting |= usb::ActingLimits::kVoltage;
        const float share = largest_V / highest_V;
        for (float &channel_V : voltage_V) {
            channel_V *= share;
        }
    }
    for (std::size_t i = 0; i < kChannels; ++i) {
        const Winding &winding = winding_[i];
        const float now_V = winding.resistance_Ohm * current_A_[i] + emf_V_[i];
        const float start_A = current_A_[i] + winding.ahead_A_per_V * (newer_V_[i] - now_V);
        const float steady_V = winding.resistance_Ohm * start_A + emf_V_[i];
        const float kept_V =
            limited(voltage_V[i], steady_V - winding.limit_V_per_A * (limit_A_ + start_A),
                    steady_V + winding.limit_V_per_A * (limit_A_ - start_A));
        if (kept_V != voltage_V[i]) {
            acting |= usb::ActingLimits::kCurrent;
            voltage_V[i] = limited(kept_V, -largest_V, largest_V);
        }
    }
    return voltage_V;
}

} // namespace springdrive::board

#include "device/usb/board/amplifier.h"

namespace springdrive::board {

namespace {

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
      current_limit_A_(settings.current_limit_A) {
    for (std::size_t i = 0; i < kChannels; ++i) {
        sustaining_V_[i] = settings.current_limit_A * settings.winding[i].resistance_Ohm;
    }
}

Triple Amplifier::limited_V(Triple voltage_V, float largest_V, std::uint8_t &acting) const {
    float highest_V = 0.0F;
    for (std::size_t i = 0; i < kChannels; ++i) {
        const bool drives_on = voltage_V[i] * current_A_[i] > 0.0F;
        if (drives_on && magnitude(current_A_[i]) >= current_limit_A_ &&
            magnitude(voltage_V[i]) > sustaining_V_[i]) {
            voltage_V[i] = voltage_V[i] < 0.0F ? -sustaining_V_[i] : sustaining_V_[i];
            acting |= usb::ActingLimits::kCurrent;
        }
        highest_V = magnitude(voltage_V[i]) > highest_V ? magnitude(voltage_V[i]) : highest_V;
    }
    if (highest_V > largest_V) {
        acting |= usb::ActingLimits::kVoltage;
        const float share = largest_V / highest_V;
        for (float &channel_V : voltage_V) {
            channel_V *= share;
        }
    }
    return voltage_V;
}

} // namespace springdrive::board

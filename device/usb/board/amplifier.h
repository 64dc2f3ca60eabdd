// The amplifiers: one step of (6) with lead compensation, on all three windings.
//
//   e_A = e_W + R̂ i + L̂ di/dt
//
// The voltage acts a lag τ after the currents were sampled. Fed back as it is, R̂ i(t − τ) would add
// the inductance R̂ τ, a tenth of L at 40 kHz. So it is fed back for the currents to be expected at
// the middle of the voltage's action, i + τ di/dt, which leaves errors of second order in τ:
//
//   e_A = e_W + R̂ i + B di/dt      B = L̂ + τ R̂
//
// di/dt is the difference of two samples behind a low-pass filter of the lead's bandwidth. It is
// measured, not integrated from voltages, so there is nothing to wind up where a limit acts.
//
// Limits: a winding at its current limit gets no more voltage in that direction than sustains it at
// standstill. Above the largest voltage, all three are scaled by one factor: channels that are
// clipped one by one would turn the force, and less than R̂ i cancels less, so it is never unstable.
#pragma once

#include "device/usb/board/matrix.h"
#include "device/usb/board/settings.h"

namespace springdrive::board {

/// A command as the loop needs it.
struct DriveSettings {
    Triple e_W_V{};
    SymmetricMatrix cancelled_Ohm;
    SymmetricMatrix lead_H; ///< B
    bool is_diagonal = true;
};

[[nodiscard]] constexpr DriveSettings drive_settings(const usb::Command &command, float lag_s) {
    return {command.e_W_V, command.cancelled_resistance_Ohm,
            scaled_sum(lag_s, command.cancelled_resistance_Ohm, command.cancelled_inductance_H),
            command.cancelled_resistance_Ohm.is_diagonal() &&
                command.cancelled_inductance_H.is_diagonal()};
}

class Amplifier {
public:
    explicit Amplifier(const BoardSettings &settings);

    /// Measures di/dt. In every loop, in any state, so that driving begins with it.
    void observe(const Triple &current_A) {
        for (std::size_t i = 0; i < kChannels; ++i) {
            const float slope_A_per_s = (current_A[i] - current_A_[i]) * rate_hz_;
            slope_A_per_s_[i] += slope_share_ * (slope_A_per_s - slope_A_per_s_[i]);
        }
        current_A_ = current_A;
    }

    /// e_A for the currents last observed, without limits.
    [[nodiscard]] Triple voltage_V(const DriveSettings &drive) const {
        return drive.is_diagonal
                   ? add_diagonal_product(
                         add_diagonal_product(drive.e_W_V, drive.cancelled_Ohm, current_A_),
                         drive.lead_H, slope_A_per_s_)
                   : add_product(add_product(drive.e_W_V, drive.cancelled_Ohm, current_A_),
                                 drive.lead_H, slope_A_per_s_);
    }

    /// Limits voltages; notes usb::ActingLimits in `acting`.
    /// @param largest_V  of |e_A|
    [[nodiscard]] Triple limited_V(Triple voltage_V, float largest_V, std::uint8_t &acting) const;

    /// After a time without samples, di/dt is unknown.
    void forget(const Triple &current_A) {
        current_A_ = current_A;
        slope_A_per_s_ = {};
    }

private:
    float rate_hz_;
    float slope_share_; ///< of a new difference, in the filter
    float current_limit_A_;
    Triple sustaining_V_{}; ///< the current limit at standstill
    Triple current_A_{};
    Triple slope_A_per_s_{};
};

} // namespace springdrive::board

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
// Limits: above the largest voltage, all three are scaled by one factor: channels that are clipped
// one by one would turn the force, and less than R̂ i cancels less, so it is never unstable. Then
// each current is kept below its limit I, whatever is commanded. With the current i_s expected when
// the voltage begins to act,
//
//   |e_A − R i_s − e| limits to  G (I ∓ i_s)      G = L/(2 T)
//
// so that i approaches I by at most half of what is left in each loop. It needs neither R nor the
// speed: e is what a winding's voltage is measured to exceed R i + L di/dt by, that is back-EMF of
// either sign, (R(T) − R) i, and the errors of supply and bridge. An L that is wrong by less than
// half does no harm.
#pragma once

#include "device/usb/board/settings.h"
#include "device/usb/board/values.h"

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

    /// Measures di/dt and e. In every loop, in any state, so that driving begins with them.
    void observe(const Triple &current_A) {
        for (std::size_t i = 0; i < kChannels; ++i) {
            const Winding &winding = winding_[i];
            const float slope_A_per_s = (current_A[i] - current_A_[i]) * rate_hz_;
            const float acted_V = newer_V_[i] + older_share_ * (older_V_[i] - newer_V_[i]);
            const float emf_V = acted_V - winding.inductance_H * slope_A_per_s -
                                0.5F * winding.resistance_Ohm * (current_A[i] + current_A_[i]);
            slope_A_per_s_[i] += slope_share_ * (slope_A_per_s - slope_A_per_s_[i]);
            emf_V_[i] += slope_share_ * (emf_V - emf_V_[i]);
        }
        current_A_ = current_A;
    }

    /// The voltages that follow those of the last loop; 0 of windings that are not driven.
    void apply(const Triple &voltage_V) {
        older_V_ = newer_V_;
        newer_V_ = voltage_V;
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

    /// Limits voltages; adds usb::ActingLimits to `acting`.
    /// @param largest_V  of |e_A|
    [[nodiscard]] Triple limited_V(Triple voltage_V, float largest_V, std::uint8_t &acting) const;

    /// After a time without samples, di/dt is unknown, and e the one before; after samples that
    /// were no numbers, neither is known.
    void forget(const Triple &current_A) {
        current_A_ = current_A;
        slope_A_per_s_ = {};
        for (float &emf_V : emf_V_) {
            emf_V = magnitude(emf_V) <= kAnyEmf_V ? emf_V : 0.0F;
        }
    }

private:
    static constexpr float kAnyEmf_V = 100.0F;

    struct Winding {
        float resistance_Ohm = 0.0F;
        float inductance_H = 0.0F;
        float limit_V_per_A = 0.0F; ///< G
        float ahead_A_per_V = 0.0F; ///< rise of the current until a new voltage begins to act
    };

    float rate_hz_;
    float slope_share_; ///< of a new difference, in the filters
    float older_share_; ///< by which the older of two voltages acts between two samples
    float limit_A_;     ///< I, as a sensor reads it whose gain is at its least
    std::array<Winding, kChannels> winding_{};
    Triple newer_V_{};
    Triple older_V_{};
    Triple current_A_{};
    Triple slope_A_per_s_{};
    Triple emf_V_{}; ///< e
};

} // namespace springdrive::board

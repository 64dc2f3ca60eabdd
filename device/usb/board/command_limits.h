// The board's own limits of commands. A command is obeyed or rejected as a whole, never altered: a
// clipped matrix would turn forces, and a host that asks for too much has an error that it should
// learn of. After a rejection the last command holds until the watchdog brakes.
//
// R̂ stays below a bound in every direction, so that no combination of currents sees less resistance
// than R minus that bound, which is R at 25 °C within its tolerance, and what it certainly rose.
#pragma once

#include "device/usb/board/matrix.h"
#include "device/usb/board/settings.h"

namespace springdrive::board {

/// @param largest_cancelled_Ohm  at the windings' present temperatures
/// @return ok, coupled or beyond_limits
[[nodiscard]] constexpr usb::FrameStatus check_limits(const usb::Command &command,
                                                      const BoardSettings &settings,
                                                      const Triple &largest_cancelled_Ohm) {
    using usb::FrameStatus;
    if (command.mode != usb::Mode::drive) {
        return FrameStatus::ok;
    }
    const SymmetricMatrix &R_hat = command.cancelled_resistance_Ohm;
    const SymmetricMatrix &L_hat = command.cancelled_inductance_H;
    if (!settings.couples_channels && !(R_hat.is_diagonal() && L_hat.is_diagonal())) {
        return FrameStatus::coupled;
    }
    const auto uniform = [](float bound) { return Triple{bound, bound, bound}; };
    const auto negated = [](const SymmetricMatrix &M) { return scaled_sum(-1.0F, M, {}); };
    bool is_within = true;
    for (const float e_W_V : command.e_W_V) {
        is_within = is_within && magnitude(e_W_V) <= settings.largest_voltage_V;
    }
    is_within = is_within && is_positive_definite(below(largest_cancelled_Ohm, R_hat)) &&
                is_positive_definite(below(uniform(settings.largest_added_Ohm), negated(R_hat))) &&
                is_positive_definite(below(uniform(settings.largest_cancelled_H), L_hat)) &&
                is_positive_definite(below(uniform(settings.largest_added_H), negated(L_hat)));
    return is_within ? FrameStatus::ok : FrameStatus::beyond_limits;
}

} // namespace springdrive::board

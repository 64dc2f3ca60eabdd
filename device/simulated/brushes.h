// What has the sign of the current, brushes and bridge: V_b tanh(i/i_b), nearly the same voltage at
// any current above i_b.
//
// Over a sub-step it is a resistance r, which can only dissipate, whatever the sub-step's length.
// r is that of the mean current x that it leaves itself, by the implicit midpoint rule of (11):
//
//   (2L/h + dR) x + V_b tanh(x/i_b) = (2L/h) i(0) + u        r = V_b tanh(x/i_b)/x
//
// with u = e_W − k_T θ̇. Second order in h; where L/r is far below h, near i = 0, the current goes
// to its balance within the sub-step and does not pass it.
//
// A film between brush and commutator grows at rest and is worn and pierced by current, so i_b
// moves between two values with the mean of |i|, over seconds. At |i| ≈ i_b that is a drift of V_b
// tanh(i/i_b)/i by some hundredths of an ohm.
#pragma once

#include "device/core/motor/motor.h"

namespace springdrive::simulated {

/// How far a mean of |i| has moved i_b from its value at rest to that after large currents.
[[nodiscard]] constexpr double film_share(double mean_A) {
    constexpr double kMidway_A = 0.3;
    return mean_A / (mean_A + kMidway_A);
}

/// r above, of a mean current x [Ω]. RT-safe.
/// @param brush_V  V_b, above 0
/// @param brush_A  i_b
[[nodiscard]] double brush_resistance_Ohm(double brush_V, double brush_A, double mean_A) noexcept;

/// x above of a spring drive's winding [A]: where R̂ x + e_W exceeds the supply, behind that and the
/// full R. RT-safe.
/// @param now  without r
[[nodiscard]] double mean_behind_brushes_A(double brush_V, double brush_A,
                                           const device::MotorParameters &motor,
                                           const device::DriveState &now, double e_W_V,
                                           double cancelled_resistance_Ohm, double step_s) noexcept;

} // namespace springdrive::simulated

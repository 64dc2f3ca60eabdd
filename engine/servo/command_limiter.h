// What of a wanted command may go to the device: a function over values, so that a record can be
// put through it again.
//
//   e_W ──► ramp ──► + soft wall at the edge ──► force and current ──► supply ──► device
//
// *Force and current.* Behind a held e_W and a steady speed each winding's current goes to
// i = (e_W − k_T θ̇)/dR as e^(−t dR/L), so the tip force J⁻ᵀ k_T i goes straight from where it is to
// where it settles. e_W is drawn towards k_T θ̇_f, where no force settles, until the force that does
// is within kLimiterShare of its limit: then, as a ball is convex, so is all on the way there,
// where all windings have one dR. What is left for the monitor to trip on is what R at 25 °C and
// its commutator's worst angle, a common dR and the filtered speed do not know.
#pragma once

#include "device/core/haptic_device.h"
#include "engine/control/motion_control.h"
#include "engine/servo/safety_limits.h"
#include "engine/servo/safety_status.h"

namespace springdrive::servo {

/// Below the limit, so that pressing hard is pushing against a force, not tripping a monitor.
inline constexpr double kLimiterShare = 0.95;

/// What stands in a tick.
struct LimiterInputs {
    control::Configuration now;
    SafetyLimits limits;
    double ramp = 0.0;                        ///< share of the command that passes
    Vector3 R_hat_limit_Ohm{Vector3::Zero()}; ///< the largest R̂ that each winding can bear
};

struct LimitedCommand {
    device::DeviceCommand command;
    ActiveLimits held_back;
    Vector3 bearable_e_W_V{Vector3::Zero()}; ///< after force and current, before the supply
    double force_share = 1.0;                ///< of the force that was wanted, let through
};

/// `wanted` must be finite. RT-safe.
[[nodiscard]] LimitedCommand limited(const device::DeviceDescription &device,
                                     const device::DeviceCommand &wanted,
                                     const LimiterInputs &inputs) noexcept;

} // namespace springdrive::servo

// Limits a requested command to what may go to the device: a function over values, so that it can
// be applied to a record again.
//
//   e_W ──► ramp ──► + soft wall at the edge ──► force and current ──► supply ──► device
//
// *Force and current.* With constant e_W and speed each winding's current approaches
// i = (e_W + R̂ o − k_T θ̇)/dR as e^(−t dR/L), with the offset o of the sensor that R̂ multiplies, so
// the tip force J⁻ᵀ k_T i moves on a straight line from its present to its steady value. R̂ o is
// taken off e_W, which is then moved towards k_T θ̇_f − R̂ o, where the steady force is zero, until
// the steady force is within kLimiterShare of its limit. As a ball is convex, the whole line is
// then within the limit, if all windings have the same dR. The monitor can still trip on what this
// neglects: it assumes R as it was observed, or else at 25 °C and the worst commutator angle, a
// common dR and the filtered speed.
#pragma once

#include "device/core/haptic_device.h"
#include "engine/control/motion_control.h"
#include "engine/control/winding_observer.h"
#include "engine/servo/safety_limits.h"
#include "engine/servo/safety_status.h"

namespace springdrive::servo {

/// Below the limit, so that pressing hard meets a maximum force and does not trip the monitor.
inline constexpr double kLimiterShare = 0.95;

/// The state and limits of a tick.
struct LimiterInputs {
    control::Configuration now;
    SafetyLimits limits;
    double ramp = 0.0;                        ///< share of the command that is passed on
    Vector3 R_hat_limit_Ohm{Vector3::Zero()}; ///< the largest safe R̂ of each winding
    control::ObservedMotors motors;
    Vector3 trim_V{Vector3::Zero()}; ///< part of e_W that no current is due to, see drive_gains.h
};

struct LimitedCommand {
    device::DeviceCommand command;
    ActiveLimits active_limits;
    Vector3 permissible_e_W_V{Vector3::Zero()}; ///< after force and current, before the supply
    double force_share = 1.0;                   ///< share of the requested force that is passed on
};

/// `wanted` must be finite. RT-safe.
[[nodiscard]] LimitedCommand limited(const device::DeviceDescription &device,
                                     const device::DeviceCommand &requested,
                                     const LimiterInputs &inputs) noexcept;

} // namespace springdrive::servo

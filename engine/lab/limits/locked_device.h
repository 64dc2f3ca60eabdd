// The experiment of section VI on the simulated device: the tip is held in a vice that measures its
// force while the servo renders a surface that the tip has penetrated (figures 5 and 6).
//
//   start: the vice holds the tip 1 mm outside a large flat plate; the servo's ramp runs up
//   zero:  the sensor is set to zero there, as one does, so that weight does not count
//   press: the vice moves the tip along the normal, to where it is `penetration_m` inside
//   hold:  the force is averaged over 50 ms
//
// Where the windings' resistances are observed, the vice has moved the tip along the plate before.
//
// The vice locks the base joint too: the device is planar, and α is at the bound (29) of the planar
// device.
#pragma once

#include "device/core/device_description.h"
#include "engine/control/tuning.h"
#include "engine/lab/loops/link_plane.h"

#include <cstdint>

namespace springdrive::limits {

struct LockedDeviceOptions {
    Vector3 q_rad{Vector3::Zero()}; ///< the configuration, while pressed
    control::Tuning tuning;         ///< its map and α are ignored: both maps are tried, α at the
                                    ///< bound (29)
    double servo_period_s = 1e-3;
    double penetration_m = 1e-3;
    /// Friction, weight, encoder quanta and warming windings.
    bool effects = true;
    std::uint64_t device_seed = 0; ///< with effects: which device of its kind, with all its own
    /// R̂ follows the resistances that the servo has observed in 2.5 s of touch just before.
    bool observes_resistance = false;
};

/// The force of the device on the sensor, in the plane of the links.
struct LockedForce {
    loops::Vector2 measured_N{0.0, 0.0};
    loops::Vector2 predicted_N{0.0, 0.0}; ///< (21) or (27) times the penetration
    double error_rad = 0.0; ///< from the normal to the measured force, counter-clockwise
    double predicted_error_rad = 0.0;
};

/// Holds the tip inside a plate whose normal points out of it at `normal_rad`, counter-clockwise
/// from outward: −π/2 for a wall above the device. Takes between one and several hundred
/// milliseconds.
/// @throw InputError for a configuration or tuning without a solution (see `planar_stiffness`), a
///        configuration that the device cannot take (see `check_configuration`), or where the
///        safety monitor trips.
[[nodiscard]] LockedForce press_locked_device(const device::DeviceDescription &device,
                                              const LockedDeviceOptions &options,
                                              control::MotionMap map, double normal_rad);

/// The largest force at the tip, in the plane of the links, that Coulomb friction can hold [N].
[[nodiscard]] double breakaway_force_N(const device::DeviceDescription &device,
                                       const Vector3 &q_rad);

/// The penetration, 4 mm at most, at which a map requests in no direction more than half of the
/// safety monitor's limits of tip force and current. With it, both maps are pressed about equally
/// hard.
/// @throw InputError as `planar_stiffness` does.
[[nodiscard]] double harmless_penetration_m(const device::DeviceDescription &device,
                                            const control::Tuning &tuning, const Vector3 &q_rad,
                                            control::MotionMap map);

} // namespace springdrive::limits

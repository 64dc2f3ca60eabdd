// The experiment of section VI on the simulated device: the tip held in a vice that measures its
// force, the servo rendering a surface that the tip has penetrated (figures 5 and 6).
//
//   start: the vice holds the tip 1 mm outside a large flat plate; the servo's ramp runs up
//   zero:  the sensor is set to zero there, as one does, so that weight does not count
//   press: the vice moves the tip along the normal, to where it is `penetration_m` inside
//   hold:  the force is averaged over 50 ms
//
// The vice leaves the base joint no freedom either: the device is the planar one, and α is at the
// bound (29) of that.
#pragma once

#include "device/core/device_file.h"
#include "engine/control/tuning.h"
#include "engine/lab/loops/link_plane.h"

namespace springdrive::limits {

struct LockedDeviceOptions {
    Vector3 q_rad{Vector3::Zero()}; ///< the configuration, while pressed
    control::Tuning tuning;         ///< its map and α do not enter: both maps, the bound (29)
    double servo_period_s = 1e-3;
    double penetration_m = 1e-3;
    /// Friction, weight, encoder quanta, warming windings and motors whose dR differs. The ripple
    /// of R is in that difference: at a locked angle it is one more constant.
    bool effects = true;
    /// With effects, R of the third joint's motor is above the data sheet's by this share, and of
    /// the second's below. dR, where it stays whole, takes R/dR times as much.
    double resistance_spread = 0.0015;
};

/// The force of the device on the sensor, in the plane of the links.
struct LockedForce {
    loops::Vector2 measured_N{0.0, 0.0};
    loops::Vector2 predicted_N{0.0, 0.0}; ///< (21) or (27) times the penetration
    double error_rad = 0.0; ///< from the normal to what was measured, counter-clockwise
    double predicted_error_rad = 0.0;
};

/// Holds the tip inside a plate whose normal points out of it at `normal_rad`, counter-clockwise
/// from outward: −π/2 for a wall above the device. Takes milliseconds to hundreds of them.
/// @throw InputError for a configuration or tuning that gives no answer (see `planar_stiffness`),
///        one that the device cannot take (see `check_configuration`), or where the safety monitor
///        trips.
[[nodiscard]] LockedForce press_locked_device(const device::DeviceDescription &device,
                                              const LockedDeviceOptions &options,
                                              control::MotionMap map, double normal_rad);

/// The largest force at the tip, in the plane of the links, that Coulomb friction can hold [N].
[[nodiscard]] double breakaway_force_N(const device::DeviceDescription &device,
                                       const Vector3 &q_rad);

/// The penetration, 4 mm at most, at which a map asks in no direction for more than half of what
/// the safety monitor lets pass, of tip force and of current. Both maps pressed so are pressed
/// about as hard.
/// @throw InputError as `planar_stiffness` does.
[[nodiscard]] double harmless_penetration_m(const device::DeviceDescription &device,
                                            const control::Tuning &tuning, const Vector3 &q_rad,
                                            control::MotionMap map);

} // namespace springdrive::limits

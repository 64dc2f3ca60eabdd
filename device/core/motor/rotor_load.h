// Mechanical load of a rotor.
#pragma once

namespace springdrive::device {

/// The load of a rotor, reduced to motor coordinates.
struct RotorLoad {
    double inertia_kg_m2 = 0.0;
    double damping_Nms_per_rad = 0.0;
    double stiffness_Nm_per_rad = 0.0; ///< to ground
};

} // namespace springdrive::device

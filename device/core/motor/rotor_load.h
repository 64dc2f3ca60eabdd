// What moves with a rotor, or holds it.
#pragma once

namespace springdrive::device {

/// What a rotor carries or is held by, reduced to motor coordinates.
struct RotorLoad {
    double inertia_kg_m2 = 0.0;
    double damping_Nms_per_rad = 0.0;
    double stiffness_Nm_per_rad = 0.0; ///< to the ground
};

} // namespace springdrive::device

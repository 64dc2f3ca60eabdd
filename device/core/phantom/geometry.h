// The dimensions and masses of a PHANTOM that its kinematics and dynamics need.
#pragma once

#include "base/vector.h"

namespace springdrive::device {

/// Link lengths and transmission; θ = N q, N diagonal. The values come from a device file.
struct PhantomGeometry {
    double upper_arm_m = 0.0;                    ///< l₁
    double forearm_m = 0.0;                      ///< l₂
    double crank_m = 0.0;                        ///< l₃, whose rod turns the forearm
    Vector3 transmission_ratio{Vector3::Ones()}; ///< diagonal of N, motor turns per joint turn
};

/// One moving part of the linkage. It turns with q₂ (upper arm, rod) or with q₃ (crank, forearm),
/// and with the whole linkage about the vertical axis.
struct LinkBody {
    double mass_kg = 0.0;
    double centre_m = 0.0; ///< centre of mass along the link, from the joint that it turns about
    /// Normal to the linkage's plane, across the link in that plane, along the link; about the
    /// joint for upper arm and crank, about the centre of mass for rod and forearm.
    Vector3 inertia_kg_m2{Vector3::Zero()};
};

/// The four links that move in the plane, including the motors that they carry.
struct LinkageInertia {
    double base_kg_m2 = 0.0;  ///< of all parts that turn with q₁ alone, about the vertical axis
    LinkBody upper_arm;       ///< l₁ from the base joint, with the third joint's motor behind it
    LinkBody crank;           ///< l₃ from the base joint, with the second joint's motor behind it
    LinkBody rod;             ///< from the crank's end to the forearm, parallel to the upper arm
    LinkBody forearm;         ///< l₂ from the elbow to the tip
    double tip_load_kg = 0.0; ///< thimble, stylus or sensor, a point mass at the tip
};

} // namespace springdrive::device

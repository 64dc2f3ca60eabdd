// Tip stiffness in the plane of the links: the ellipse of the inverse map and the circle of the
// transpose map (Fig. 3).
#pragma once

#include "device/core/device_description.h"
#include "engine/control/tuning.h"
#include "engine/lab/loops/link_plane.h"

#include <vector>

namespace springdrive::loops {

/// The stiffnesses of both maps for a device whose base is locked [N/m]: force per displacement.
struct PlanarStiffness {
    Matrix2 inverse;                  ///< (21), with K_q diagonal where motors differ
    Matrix2 transpose;                ///< (27): α k̄ I
    double alpha_rad2_per_m2 = 0.0;   ///< at the bound (29) of the planar device
    Vector2 K_q_Nm_per_rad{0.0, 0.0}; ///< diagonal of (20), for the motors of q₂ and q₃
};

/// At rest: K_q = (1 − η) K_DC of each motor (13), and α as large as (29) allows.
/// @throw InputError where the links are aligned, or where the tuning has no static stiffness.
[[nodiscard]] PlanarStiffness planar_stiffness(const device::DeviceDescription &device,
                                               const control::Tuning &tuning, const Vector3 &q_rad);

/// A displacement's direction and the forces that result.
struct EllipsePoint {
    double angle_rad = 0.0; ///< of the displacement
    Vector2 inverse_N_per_m{0.0, 0.0};
    Vector2 transpose_N_per_m{0.0, 0.0};
};

/// One full turn: K n for `points` unit vectors n, and the first once more. The semi-axes are the
/// eigenvalues of K.
[[nodiscard]] std::vector<EllipsePoint> stiffness_ellipses(const PlanarStiffness &stiffness,
                                                           int points);

/// The angle from a normal to the inverse map's force, for a small penetration along that normal.
[[nodiscard]] double inverse_direction_error_rad(const PlanarStiffness &stiffness,
                                                 double normal_rad);

} // namespace springdrive::loops

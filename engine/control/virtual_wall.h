// A virtual wall as force-controlled devices render it, for the comparison with a current drive.
#pragma once

#include "base/vector.h"
#include "engine/contact/contact.h"
#include "engine/control/motion_control.h"

#include <algorithm>

namespace springdrive::control {

struct VirtualWall {
    double stiffness_N_per_m = 0.0;
    double damping_Ns_per_m = 0.0;
};

/// F = (1 − η) (K (x₀ − x) − B ẋ_f) on the tip [N]; zero where nothing is touched. A surface has a
/// normal: it pushes along that and never pulls.
[[nodiscard]] inline Vector3 wall_force_N(const VirtualWall &wall, const Configuration &now,
                                          const contact::Contact &contact, double eta) {
    if (!contact.touching) {
        return Vector3::Zero();
    }
    const Vector3 force_N = (1.0 - eta) * (wall.stiffness_N_per_m * (contact.x0_m - now.tip_m) -
                                           wall.damping_Ns_per_m * now.tip_velocity_m_per_s());
    return contact.normal.isZero() ? force_N
                                   : std::max(0.0, contact.normal.dot(force_N)) * contact.normal;
}

} // namespace springdrive::control

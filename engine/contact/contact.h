// What the proxy tells motion control: the contact constraint of one servo tick.
#pragma once

#include "base/vector.h"

#include <cstdint>

namespace springdrive {

/// In free space x₀ = x, P = I and η = 1, so that (30) needs no case of its own.
///
/// P (DESIGN section 3) is the projector onto the directions in which x₀ may move with the tip:
/// I on no plane, I − n nᵀ on a face, t tᵀ on an edge, 0 at a vertex.
struct Contact {
    bool touching = false;
    Vector3 x0_m{Vector3::Zero()};               ///< x₀: where the proxy rests
    Matrix3 allowed_motion{Matrix3::Identity()}; ///< P, see below
    Vector3 normal{Vector3::Zero()};             ///< unit, from the tip to x₀; zero when free
    double eta = 1.0;                            ///< η of the material touched
    int active_constraints = 0;                  ///< 0 free, 1 face, 2 edge, 3 vertex
    std::uint32_t triangle = 0;                  ///< one of those touched, if touching
};

} // namespace springdrive

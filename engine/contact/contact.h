// What the proxy reports to motion control: the contact constraint of one servo tick.
#pragma once

#include "base/vector.h"

#include <cstdint>

namespace springdrive::contact {

/// In free space x₀ = x, P = I and η = 1, so that (30) needs no special case.
///
/// P (docs/design.md, "Contact and maps") is the projector onto the directions in which x₀ may move
/// with the tip: I without contact, I − n nᵀ on a face, t tᵀ on an edge, 0 at a vertex and where
/// friction holds it.
struct Contact {
    bool touching = false;
    Vector3 x0_m{Vector3::Zero()};                  ///< x₀: where the proxy rests
    Matrix3 tangent_projector{Matrix3::Identity()}; ///< P, see above
    Vector3 normal{Vector3::Zero()};                ///< unit, from the tip to x₀; zero when free
    double eta = 1.0;                               ///< η of the material touched
    int active_constraints = 0;                     ///< 0 free, 1 face, 2 edge, 3 vertex
    bool sticking = false;                          ///< friction holds x₀ where it is
    bool settled = true;                            ///< false: the tick's budget ran out before

    // Of the first of the constraints, if touching.
    Vector3 surface_m{Vector3::Zero()};   ///< the point of the surface nearest to x₀
    Vector3 barycentric{Vector3::Zero()}; ///< of that point in the facet touched, which may be a
                                          ///< part of the triangle; zero on a shape
    std::uint32_t triangle = 0;           ///< of the soup; on a shape the soup's size + its index
    std::uint16_t material = 0;           ///< index into the surface's materials
};

} // namespace springdrive::contact

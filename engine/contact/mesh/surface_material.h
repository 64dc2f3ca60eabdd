// What a touchable surface is made of, as its scene says.
#pragma once

#include <cstdint>
#include <string>

namespace springdrive::contact {

/// From where a surface can be touched.
enum class TouchSides : std::uint8_t {
    automatic, ///< from outside only if it is closed, from both sides if it is open
    one,       ///< from the side that its normals point to
    two,       ///< from both
};

/// What is felt on one glTF node.
struct SurfaceMaterial {
    std::string name;              ///< the node's name, for messages
    double eta = 0.0;              ///< η of (30): 0 rigid, 1 free space
    double static_friction = 0.0;  ///< Coulomb coefficient up to which contact sticks
    double dynamic_friction = 0.0; ///< the one while it slides; not above the static one
    TouchSides sides = TouchSides::automatic;
};

} // namespace springdrive::contact

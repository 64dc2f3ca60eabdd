// Material of a touchable surface, as its scene specifies it.
#pragma once

#include <cstdint>
#include <string>

namespace springdrive::contact {

/// The sides from which a surface can be touched.
enum class TouchSides : std::uint8_t {
    automatic, ///< from outside only if it is closed, from both sides if it is open
    one,       ///< from the side that its normals point to
    two,       ///< from both
};

/// Haptic material of one glTF node.
struct SurfaceMaterial {
    std::string name;              ///< the node's name, for messages
    double eta = 0.0;              ///< η of (30): 0 rigid, 1 free space
    double static_friction = 0.0;  ///< Coulomb coefficient while sticking
    double dynamic_friction = 0.0; ///< coefficient while sliding; not above the static one
    TouchSides sides = TouchSides::automatic;
};

} // namespace springdrive::contact

// What a scene is there to let one feel.
#pragma once

#include "base/vector.h"

#include <optional>
#include <string>

namespace springdrive::scene {

/// Where a scene is to be touched.
struct TouchSpot {
    Vector3 point_m{Vector3::Zero()}; ///< on the surface
    Vector3 normal{Vector3::UnitY()}; ///< unit, out of the surface
};

/// All of it may be absent.
struct Lesson {
    std::string title;
    std::string feel;              ///< one sentence: what to do, and what to feel
    std::optional<TouchSpot> spot; ///< where the direction of the force is to be seen

    [[nodiscard]] bool is_empty() const { return title.empty() && feel.empty() && !spot; }
};

/// Words on a part of the scene.
struct Caption {
    std::string text;
    Vector3 at_m{Vector3::Zero()}; ///< the middle of the part's upper side
};

} // namespace springdrive::scene

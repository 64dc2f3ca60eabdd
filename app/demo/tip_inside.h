// Whether the tip lies in a solid, where it feels nothing: surfaces that bound a volume stop it
// from outside only.
#pragma once

#include "engine/scene/scene.h"

#include <cstdint>
#include <optional>

namespace springdrive::app {

/// In a closed mesh or a solid shape of the scene. Open meshes and sheets have no inside.
[[nodiscard]] bool lies_inside(const scene::Scene &scene, const Vector3 &point_m);

/// The same, asked in every frame: computed anew only for another scene or place, and at most four
/// times a second, as it looks at all triangles.
class TipInside {
public:
    /// @param scene_id  its number
    /// @param time_s    by any clock of the window
    [[nodiscard]] bool at(const scene::Scene &scene, std::uint32_t scene_id, const Vector3 &tip_m,
                          double time_s);

private:
    std::uint32_t scene_id_ = 0;
    Vector3 tip_m_{Vector3::Zero()};
    std::optional<double> next_s_;
    bool is_inside_ = false;
};

} // namespace springdrive::app

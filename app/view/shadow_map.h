// What the key light sees: shadows that solids and scene cast on each other.
#pragma once

#include "app/view/gl_objects.h"

#include <functional>

namespace springdrive::app {

/// The key light, from the upper left of the user; unit.
inline const glm::vec3 kTowardsKeyLight{-0.4478F, 0.7957F, 0.4078F};

/// Of depths along the light, which is parallel, over a ball of space.
class ShadowMap {
public:
    /// @param size_px  width and height
    explicit ShadowMap(int size_px);

    /// Redraws the map with `draw_casters`, which uses `depth`, with all uniforms set except
    /// `model`. Leaves its own framebuffer bound, and the viewport changed.
    void cast(const Program &depth, const glm::mat4 &light,
              const std::function<void(const Program &depth)> &draw_casters);

    void bind(int unit) const { depths_.bind(unit); }

private:
    int size_px_;
    DepthTexture depths_;
    Framebuffer framebuffer_;
};

/// Takes a ball of world space to coordinates from 0 to 1: across the light, and away from it.
[[nodiscard]] glm::mat4 light_matrix(const glm::vec3 &towards_light, const glm::vec3 &centre_m,
                                     float radius_m);

} // namespace springdrive::app

// A soft shadow of the key light on a square of floor, as a small texture: independent of the
// window's buffers, blurred once instead of for every pixel of the floor.
#pragma once

#include "app/view/gl_objects.h"

#include <functional>

namespace springdrive::app {

/// The square of floor that receives shadows.
struct ShadowArea {
    glm::vec2 centre_m{0.0F}; ///< x, z
    float half_size_m = 0.5F;
    float height_m = 0.0F;

    bool operator==(const ShadowArea &) const = default;
};

/// The programs that draw a mask, shared by all masks.
struct ShadowPrograms {
    ShadowPrograms();

    Program cast;
    Program cast_masked; ///< with MASK defined
    Program blur;
};

class ShadowMask {
public:
    ShadowMask();

    using DrawCasters = std::function<void(const Program &cast)>;

    /// Redraws the mask with `draw_casters`, which uses programs.cast, with all uniforms set except
    /// `model`; then with `draw_masked`, if any, which uses programs.cast_masked in the same way.
    /// Leaves its own framebuffer bound, and the viewport and blending changed.
    void cast(const ShadowPrograms &programs, const ShadowArea &area,
              const DrawCasters &draw_casters, const DrawCasters &draw_masked = {});

    /// 0 is lit, 1 is darkest; coordinates from 0 to 1 cover the area along x and along z.
    [[nodiscard]] const Texture2D &texture() const { return mask_.texture; }

private:
    struct Target {
        Target();

        Texture2D texture;
        Framebuffer framebuffer;
    };

    void blur_into(const Target &to, const Target &from, const Program &blur,
                   const glm::vec2 &step);

    Target mask_;
    Target half_blurred_;
    VertexArray no_vertices_;
};

} // namespace springdrive::app

// The shadows of the key light: those that solids and scene cast on each other, and soft ones on
// the floor with its grid in centimetres. A mask of the latter is a small texture, independent of
// the window's buffers, blurred once instead of for every pixel of the floor.
#pragma once

#include "app/view/camera.h"
#include "app/view/gl_objects.h"
#include "app/view/painters.h"
#include "app/view/scene_meshes.h"
#include "device/core/device_description.h"

#include <functional>
#include <span>

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

class Floor {
public:
    Floor();

    void lay(const device::Workspace &workspace, double height_m);
    void scene_changed() { scene_cast_ = false; }

    /// Updates outdated shadows. Binds its own framebuffers and sets the viewport.
    void cast_shadows(const SceneMeshes &scene, const SolidPainter &painter,
                      std::span<const Solid> moving);

    /// Blended over the framebuffer; translucent from below.
    void draw(const glm::mat4 &view_projection, const Vector3 &eye_m, double pixel_scale) const;

private:
    Program program_;
    ShadowPrograms shadow_programs_;
    ShadowArea area_;
    ShadowMask scene_shadow_; ///< the scene is static: cast once
    ShadowMask moving_shadow_;
    bool scene_cast_ = false;
    VertexArray no_vertices_;
};

} // namespace springdrive::app

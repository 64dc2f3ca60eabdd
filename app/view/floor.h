// The floor: a grid in centimetres, and on it the shadows of scene and linkage.
#pragma once

#include "app/view/camera.h"
#include "app/view/gl_objects.h"
#include "app/view/scene_meshes.h"
#include "app/view/shadow_mask.h"
#include "app/view/solid_painter.h"
#include "device/core/device_description.h"

#include <span>

namespace springdrive::app {

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

// Draws the 3-D view: scene, floor, linkage, and what marks the haptics. OpenGL 3.3 core, no
// multisampling needed, content enough for a software renderer.
#pragma once

#include "app/view/camera.h"
#include "app/view/floor.h"
#include "app/view/gl_objects.h"
#include "app/view/scene_meshes.h"
#include "app/view/solid_painter.h"
#include "app/view/view_state.h"
#include "engine/scene/scene.h"

#include <optional>
#include <span>

namespace springdrive::app {

/// Framebuffer pixels, origin bottom left.
struct ViewportPixels {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;
};

/// One thread, that of the OpenGL context, which must be current for all of it.
class Renderer {
public:
    /// @throw std::runtime_error with the shader's name and log if OpenGL does not take it.
    Renderer();

    /// Draws another scene as soon as `upload` has got it onto the graphics card; until then, the
    /// one before. @param scene must stay until then, or until another is set
    void set_scene(const scene::Scene &scene) { next_scene_.emplace(scene); }

    /// Goes on with what `set_scene` began, for about `duration_s`.
    /// @throw std::runtime_error if OpenGL cannot hold it; the scene before is then still there.
    void upload(double duration_s);

    /// Draws into the viewport of the framebuffer that is bound, and nowhere else.
    /// Leaves depth test, blending, culling and scissor off, and no vertex array bound.
    /// @param pixel_scale framebuffer pixels in a pixel of the layout, 2 on a high-density screen
    void draw(const Camera &camera, const ViewportPixels &viewport, const ViewState &state,
              double pixel_scale);

private:
    struct Frame;

    void draw_background() const;
    void draw_scene_and_linkage(const Frame &frame) const;
    void draw_markers(const Frame &frame) const;
    void draw_translucent(const Frame &frame) const;

    Program background_;
    Program lit_;
    Program lit_translucent_;
    SolidPainter painter_;
    SceneMeshes scene_;
    std::optional<SceneMeshes> next_scene_; ///< on its way to the graphics card
    Floor floor_;
    VertexArray no_vertices_;
};

} // namespace springdrive::app

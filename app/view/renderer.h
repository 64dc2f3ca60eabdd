// Draws the 3-D view: scene, floor, linkage and markers, with shadows and several samples per
// pixel. OpenGL 3.3 core, fast enough for a software renderer.
#pragma once

#include "app/view/camera.h"
#include "app/view/gl_objects.h"
#include "app/view/painters.h"
#include "app/view/scene_meshes.h"
#include "app/view/shadows.h"
#include "app/view/view_state.h"
#include "engine/scene/scene.h"

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {

/// Framebuffer pixels, origin bottom left.
struct ViewportPixels {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;
};

/// Must be used in the thread of the OpenGL context, which must be current for all calls.
class Renderer {
public:
    /// @throw std::runtime_error with the shader's name and log if OpenGL rejects it.
    /// @param samples  per pixel; 0 for none beside the pixel itself
    explicit Renderer(int samples);

    /// Sets the scene to draw once `upload` has transferred it to the graphics card; until then,
    /// the previous one is drawn. @param scene must exist until then, or until another is set
    void set_scene(const scene::Scene &scene) { next_scene_.emplace(scene); }

    /// Continues to upload the scene of `set_scene` for about `duration_s`.
    /// @throw std::runtime_error if OpenGL cannot hold it; the previous scene is then kept.
    void upload(double duration_s);

    /// Warnings on how the scene being uploaded is drawn, each once.
    [[nodiscard]] std::vector<std::string> take_warnings() { return std::exchange(warnings_, {}); }

    /// Draws only into the viewport of the bound framebuffer. Leaves depth test, blending, culling
    /// and scissor test off, and no vertex array bound.
    /// @param pixel_scale framebuffer pixels per layout pixel, 2 on a high-density screen
    /// @param is_seen  otherwise only `marks_text` is renewed
    void draw(const Camera &camera, const ViewportPixels &viewport, const ViewState &state,
              double pixel_scale, bool is_seen = true);

    /// What the marks of the last frame took: "60 draw calls, 120 flat triangles".
    [[nodiscard]] std::string marks_text() const {
        return std::to_string(mark_calls_) + " draw calls, " + std::to_string(flat_.triangles()) +
               " flat triangles";
    }

    /// Measured of a recent frame.
    [[nodiscard]] const FrameLoad &load() const { return meter_.latest(); }

private:
    struct Frame;

    void cast_shadows(const Frame &frame, const ViewState &state);
    /// Takes a lit program into use, with its uniforms set: camera, lights, and the identity
    /// transformation.
    const Program &begin(const LitVariant &variant, const Frame &frame);
    void draw_background() const;
    void draw_scene_and_linkage(const Frame &frame);
    void draw_creases(const Frame &frame) const;
    void draw_ghost(const Program &lit, const Frame &frame) const;
    void draw_flat(const Frame &frame) const;
    void draw_markers(const Frame &frame);
    void draw_translucent(const Frame &frame);

    Program background_;
    LitPrograms lit_;
    SolidPainter painter_;
    FlatPainter flat_;
    int mark_calls_ = 0;
    SceneMeshes scene_;
    std::optional<SceneMeshes> next_scene_; ///< being uploaded
    std::vector<std::string> warnings_;
    Floor floor_;
    Program depth_;
    Program depth_masked_;
    Program creases_;
    glm::mat4 light_{0.0F};   ///< of the shadow maps
    ShadowMap scene_shadow_;  ///< the scene is static: cast once
    ShadowMap moving_shadow_; ///< of linkage and tip
    bool scene_cast_ = false;
    MultisampledTarget target_;
    VertexArray no_vertices_;
    FrameLoadMeter meter_;
};

} // namespace springdrive::app

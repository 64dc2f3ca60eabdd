#include "app/view/renderer.h"

#include "app/view/embedded_shaders.h"
#include "app/view/marks.h"
#include "app/view/solids.h"

#include <array>
#include <string_view>
#include <vector>

namespace springdrive::app {

namespace {

constexpr float kHiddenOpacity = 0.50F; // of markers behind or inside something
constexpr float kHiddenFlatOpacity = 0.25F;
constexpr float kCreaseOpacity = 0.5F;
constexpr float kSatin = 0.5F;       // roughness of linkage and markers
constexpr float kMarkerGlow = 0.55F; // they keep their colour on the unlit side

// The scene's shadows are seen from near; those of the linkage are cast in each frame.
constexpr int kSceneShadow_px = 1024;
constexpr int kMovingShadow_px = 512;
constexpr std::array<std::string_view, 1> kMaskedDepth{"MASK"};
constexpr double kLightPerWorkspace = 1.4; // radius of what the key light sees; includes the base

} // namespace

/// Everything drawn in one frame.
struct Renderer::Frame {
    glm::mat4 view_projection;
    Vector3 eye_m;
    Vector3 forward;
    Vector3 tip_m;
    double floor_height_m;
    std::vector<Solid> linkage;
    std::vector<Solid> markers;
    TipMarks tip;
    std::vector<Solid> bodies; ///< see-through
};

Renderer::Renderer(int samples)
    : background_("background", shaders::fullscreen_vert, shaders::background_frag),
      depth_("depth", shaders::depth_vert, shaders::depth_frag),
      depth_masked_("depth, masked", shaders::depth_vert, shaders::depth_frag, kMaskedDepth),
      creases_("creases", shaders::creases_vert, shaders::flat_frag),
      scene_shadow_(kSceneShadow_px), moving_shadow_(kMovingShadow_px), target_(samples) {
    check_gl("setting up the renderer");
}

void Renderer::upload(double duration_s) {
    if (!next_scene_) {
        return;
    }
    const bool done = next_scene_->upload(duration_s);
    if (done) {
        for (const LitVariant &variant : next_scene_->variants()) {
            lit_.with(variant); // compiled here, so that none fails later
        }
    }
    check_gl("uploading the scene");
    warnings_ = next_scene_->take_warnings();
    if (done) {
        scene_ = std::move(*next_scene_);
        next_scene_.reset();
        floor_.scene_changed();
        scene_cast_ = false;
    }
}

void Renderer::draw(const Camera &camera, const ViewportPixels &viewport, const ViewState &state,
                    double pixel_scale, bool is_seen) {
    if (viewport.width <= 0 || viewport.height <= 0) {
        return; // minimised
    }
    const double aspect = static_cast<double>(viewport.width) / viewport.height;
    const MarkerScale scale{camera, static_cast<double>(viewport.height), pixel_scale};
    Frame frame{camera.projection(aspect) * camera.view(),
                camera.eye_m(),
                camera.forward(),
                state.tip_m,
                state.floor_height_m,
                linkage_solids(state.linkage, state.floor_height_m, state.tripped),
                marker_solids(state, scale),
                tip_marks(state, scale),
                stiffness_bodies(state)};
    const std::vector<Solid> height = height_line(state, scale);
    frame.markers.insert(frame.markers.end(), height.begin(), height.end());
    flat_.set(flat_marks(state, scale));
    // Markers are drawn twice, where they are seen and where they are hidden.
    mark_calls_ = 2 * static_cast<int>(frame.markers.size() + frame.tip.tip.size()) +
                  static_cast<int>(frame.tip.ghost.size() + frame.bodies.size()) +
                  2 * flat_.calls();
    if (!is_seen) {
        return;
    }

    meter_.begin();
    GLint target = 0;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &target);
    cast_shadows(frame, state);

    target_.begin(viewport.width, viewport.height);
    glDepthMask(GL_TRUE);
    glClear(GL_DEPTH_BUFFER_BIT);
    draw_background();
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    draw_scene_and_linkage(frame);
    glEnable(GL_BLEND);
    // The framebuffer's own alpha stays 1.
    glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    glDepthMask(GL_FALSE);
    draw_creases(frame);
    floor_.draw(frame.view_projection, frame.eye_m, pixel_scale);
    draw_markers(frame);
    draw_translucent(frame);

    glDisable(GL_BLEND);
    glDisable(GL_DEPTH_TEST);
    glBindVertexArray(0);
    target_.end(static_cast<GLuint>(target), viewport.x, viewport.y);
    meter_.end();
    check_gl("drawing the view");
}

void Renderer::cast_shadows(const Frame &frame, const ViewState &state) {
    std::vector<Solid> casters = frame.linkage;
    casters.insert(casters.end(), frame.tip.tip.begin(), frame.tip.tip.end());
    floor_.lay(state.workspace, state.floor_height_m);
    floor_.cast_shadows(scene_, painter_, casters);

    const glm::mat4 light =
        light_matrix(kTowardsKeyLight, to_glm(state.workspace.centre_m),
                     static_cast<float>(kLightPerWorkspace * state.workspace.size_m.maxCoeff()));
    if (light != light_ || !scene_cast_) {
        scene_shadow_.cast(depth_, light, [&](const Program &depth) {
            depth.set("model", glm::mat4(1.0F));
            scene_.draw_solid_casters();
            depth_masked_.use();
            depth_masked_.set("light", light);
            depth_masked_.set("model", glm::mat4(1.0F));
            scene_.draw_masked_casters(depth_masked_);
        });
        light_ = light;
        scene_cast_ = true;
    }
    moving_shadow_.cast(depth_, light,
                        [&](const Program &depth) { painter_.draw_geometry(depth, casters); });
}

const Program &Renderer::begin(const LitVariant &variant, const Frame &frame) {
    const Program &lit = lit_.with(variant);
    lit.set("view_projection", frame.view_projection);
    lit.set("eye_m", to_glm(frame.eye_m));
    lit.set("tip_m", to_glm(frame.tip_m));
    lit.set("floor_height_m", static_cast<float>(frame.floor_height_m));
    lit.set("light", light_);
    lit.set("key_direction", kTowardsKeyLight);
    scene_shadow_.bind(kSceneShadowUnit);
    moving_shadow_.bind(kMovingShadowUnit);
    lit.set("model", glm::mat4(1.0F));
    lit.set("normal_matrix", glm::mat3(1.0F));
    lit.set("colour", glm::vec4(1.0F));
    lit.set("glow", 0.0F);
    lit.set("roughness", kSatin);
    return lit;
}

void Renderer::draw_background() const {
    background_.use();
    glBindVertexArray(no_vertices_.name());
    draw_arrays(GL_TRIANGLES, 3);
}

void Renderer::draw_scene_and_linkage(const Frame &frame) {
    scene_.draw_opaque(
        [&](const LitVariant &variant) -> const Program & { return begin(variant, frame); });
    const Program &lit = begin({}, frame);
    draw_ghost(lit, frame);
    painter_.draw(lit, frame.linkage);
}

void Renderer::draw_creases(const Frame &frame) const {
    creases_.use();
    creases_.set("view_projection", frame.view_projection);
    creases_.set("eye_m", to_glm(frame.eye_m));
    creases_.set("opacity", kCreaseOpacity);
    scene_.draw_creases();
}

/// Where the scene hides the tip; the linkage, which is not there yet, does not count.
void Renderer::draw_ghost(const Program &lit, const Frame &frame) const {
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_GREATER);
    lit.set("glow", 1.0F);
    painter_.draw(lit, frame.tip.ghost);
    lit.set("glow", 0.0F);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
}

void Renderer::draw_markers(const Frame &frame) {
    const std::span<const Solid> tip(frame.tip.tip);
    draw_flat(frame);
    const Program &lit = begin({}, frame);
    lit.set("glow", kMarkerGlow);
    glEnable(GL_CULL_FACE);
    glCullFace(GL_BACK);
    // First the hidden parts, dimmed. The tip is drawn last, so that it is also visible through the
    // proxy.
    for (const std::span<const Solid> solids : {std::span<const Solid>(frame.markers), tip}) {
        glDepthMask(GL_FALSE);
        glDepthFunc(GL_GREATER);
        painter_.draw(lit, solids, kHiddenOpacity);
        glDepthMask(GL_TRUE);
        glDepthFunc(GL_LESS);
        painter_.draw(lit, solids);
    }
    glDepthMask(GL_FALSE);
    painter_.draw(lit, frame.bodies);
    glDepthMask(GL_TRUE);
    glDisable(GL_CULL_FACE);
}

/// Before the solids, which stand in them.
void Renderer::draw_flat(const Frame &frame) const {
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_GREATER);
    flat_.draw(frame.view_projection, kHiddenFlatOpacity);
    glDepthFunc(GL_LESS);
    flat_.draw(frame.view_projection, 1.0F);
}

void Renderer::draw_translucent(const Frame &frame) {
    scene_.draw_translucent(
        [&](const LitVariant &variant) -> const Program & { return begin(variant, frame); },
        frame.forward);
}

} // namespace springdrive::app

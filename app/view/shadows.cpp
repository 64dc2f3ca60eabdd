#include "app/view/shadows.h"

#include "app/view/embedded_shaders.h"

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/mat4x4.hpp>

#include <array>
#include <cmath>
#include <stdexcept>
#include <string_view>

namespace springdrive::app {

namespace {

constexpr int kSize = 256;
constexpr int kBlurs = 2; // each nine texels wide
constexpr std::array<std::string_view, 1> kMaskedShadow{"MASK"};

constexpr double kShadowPerWorkspace = 1.4; // half size of the shadows' square; includes the base
constexpr float kFloorPerShadow = 2.2F;     // of the floor, which fades out at its edge
constexpr float kOpacityFromBelow = 0.25F;

} // namespace

ShadowMap::ShadowMap(int size_px) : size_px_(size_px), depths_(size_px) {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depths_.name(), 0);
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
    const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    if (status != GL_FRAMEBUFFER_COMPLETE) {
        throw std::runtime_error("OpenGL cannot draw depths into a texture");
    }
}

void ShadowMap::cast(const Program &depth, const glm::mat4 &light,
                     const std::function<void(const Program &depth)> &draw_casters) {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
    glViewport(0, 0, size_px_, size_px_);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_CULL_FACE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    glClear(GL_DEPTH_BUFFER_BIT);
    depth.use();
    depth.set("light", light);
    draw_casters(depth);
    glDisable(GL_DEPTH_TEST);
}

glm::mat4 light_matrix(const glm::vec3 &towards_light, const glm::vec3 &centre_m, float radius_m) {
    const glm::vec3 up = std::abs(towards_light.y) < 0.9F ? glm::vec3(0.0F, 1.0F, 0.0F)
                                                          : glm::vec3(0.0F, 0.0F, 1.0F);
    const glm::mat4 seen =
        glm::ortho(-radius_m, radius_m, -radius_m, radius_m, 0.0F, 2.0F * radius_m) *
        glm::lookAt(centre_m + radius_m * towards_light, centre_m, up);
    // From OpenGL's −1 to 1.
    return glm::scale(glm::translate(glm::mat4(1.0F), glm::vec3(0.5F)), glm::vec3(0.5F)) * seen;
}

ShadowPrograms::ShadowPrograms()
    : cast("shadow", shaders::shadow_vert, shaders::shadow_frag),
      cast_masked("shadow, masked", shaders::shadow_vert, shaders::shadow_frag, kMaskedShadow),
      blur("blur", shaders::fullscreen_vert, shaders::blur_frag) {}

ShadowMask::Target::Target()
    : texture(kSize, kSize, Texture2D::Format{.internal = GL_R8, .pixels = GL_RED}, {}) {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture.name(), 0);
    const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    if (status != GL_FRAMEBUFFER_COMPLETE) {
        throw std::runtime_error("OpenGL cannot draw into the texture for shadows");
    }
}

ShadowMask::ShadowMask() = default;

void ShadowMask::cast(const ShadowPrograms &programs, const ShadowArea &area,
                      const DrawCasters &draw_casters, const DrawCasters &draw_masked) {
    glViewport(0, 0, kSize, kSize);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);

    glBindFramebuffer(GL_FRAMEBUFFER, mask_.framebuffer.name());
    glClearColor(0.0F, 0.0F, 0.0F, 0.0F);
    glClear(GL_COLOR_BUFFER_BIT);
    glEnable(GL_BLEND);
    glBlendEquation(GL_MAX);
    const auto draw = [&](const Program &program, const DrawCasters &casters) {
        program.use();
        program.set("centre_m", area.centre_m);
        program.set("half_size_m", area.half_size_m);
        program.set("floor_height_m", area.height_m);
        program.set("key_direction", kTowardsKeyLight);
        casters(program);
    };
    draw(programs.cast, draw_casters);
    if (draw_masked) {
        draw(programs.cast_masked, draw_masked);
    }
    glBlendEquation(GL_FUNC_ADD);
    glDisable(GL_BLEND);

    constexpr float kTexel = 1.0F / kSize;
    programs.blur.use();
    programs.blur.set("mask", 0);
    for (int i = 0; i < kBlurs; ++i) {
        blur_into(half_blurred_, mask_, programs.blur, {kTexel, 0.0F});
        blur_into(mask_, half_blurred_, programs.blur, {0.0F, kTexel});
    }
}

void ShadowMask::blur_into(const Target &to, const Target &from, const Program &blur,
                           const glm::vec2 &step) {
    glBindFramebuffer(GL_FRAMEBUFFER, to.framebuffer.name());
    from.texture.bind(0);
    blur.set("step", step);
    glBindVertexArray(no_vertices_.name());
    draw_arrays(GL_TRIANGLES, 3);
}

Floor::Floor() : program_("floor", shaders::floor_vert, shaders::floor_frag) {}

void Floor::lay(const device::Workspace &workspace, double height_m) {
    const ShadowArea area{
        {static_cast<float>(workspace.centre_m.x()), static_cast<float>(workspace.centre_m.z())},
        static_cast<float>(kShadowPerWorkspace * workspace.size_m.maxCoeff()),
        static_cast<float>(height_m)};
    if (area != area_) {
        area_ = area;
        scene_cast_ = false;
    }
}

void Floor::cast_shadows(const SceneMeshes &scene, const SolidPainter &painter,
                         std::span<const Solid> moving) {
    if (!scene_cast_) {
        scene_shadow_.cast(
            shadow_programs_, area_,
            [&](const Program &cast) {
                cast.set("model", glm::mat4(1.0F));
                scene.draw_solid_casters();
                scene.draw_translucent_casters();
            },
            [&](const Program &cast) {
                cast.set("model", glm::mat4(1.0F));
                scene.draw_masked_casters(cast);
            });
        scene_cast_ = true;
    }
    moving_shadow_.cast(shadow_programs_, area_,
                        [&](const Program &cast) { painter.draw_geometry(cast, moving); });
}

void Floor::draw(const glm::mat4 &view_projection, const Vector3 &eye_m, double pixel_scale) const {
    program_.use();
    program_.set("view_projection", view_projection);
    program_.set("centre_m", area_.centre_m);
    program_.set("half_size_m", kFloorPerShadow * area_.half_size_m);
    program_.set("height_m", area_.height_m);
    program_.set("shadow_centre_m", area_.centre_m);
    program_.set("shadow_half_size_m", area_.half_size_m);
    program_.set("opacity",
                 eye_m.y() > static_cast<double>(area_.height_m) ? 1.0F : kOpacityFromBelow);
    program_.set("pixel_scale", static_cast<float>(pixel_scale));
    scene_shadow_.texture().bind(0);
    program_.set("scene_shadow", 0);
    moving_shadow_.texture().bind(1);
    program_.set("moving_shadow", 1);
    glBindVertexArray(no_vertices_.name());
    draw_arrays(GL_TRIANGLE_STRIP, 4);
}

} // namespace springdrive::app

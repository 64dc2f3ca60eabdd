#include "app/view/shadow_mask.h"

#include "app/view/embedded_shaders.h"
#include "app/view/shadow_map.h"

#include <array>
#include <stdexcept>
#include <string_view>

namespace springdrive::app {

namespace {

constexpr int kSize = 256;
constexpr int kBlurs = 2; // each nine texels wide
constexpr std::array<std::string_view, 1> kMaskedShadow{"MASK"};

} // namespace

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

} // namespace springdrive::app

#include "app/view/shadow_map.h"

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include <cmath>
#include <stdexcept>

namespace springdrive::app {

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

} // namespace springdrive::app

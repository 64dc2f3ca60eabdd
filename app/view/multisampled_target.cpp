#include "app/view/multisampled_target.h"

#include <algorithm>
#include <stdexcept>

namespace springdrive::app {

MultisampledTarget::Buffers::Buffers(int wanted, int wide, int high) : width(wide), height(high) {
    GLint most = 0;
    glGetIntegerv(GL_MAX_SAMPLES, &most);
    const GLint samples = std::min(wanted, most);
    glBindRenderbuffer(GL_RENDERBUFFER, colour.name());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_RGBA8, width, height);
    glBindRenderbuffer(GL_RENDERBUFFER, depth.name());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH_COMPONENT24, width, height);
    glBindRenderbuffer(GL_RENDERBUFFER, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth.name());
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        throw std::runtime_error("OpenGL cannot draw into a framebuffer with several samples");
    }
}

void MultisampledTarget::begin(int width, int height) {
    if (buffers_ == nullptr || buffers_->width != width || buffers_->height != height) {
        buffers_.reset(); // first, so that both are never held
        buffers_ = std::make_unique<Buffers>(samples_, width, height);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, buffers_->framebuffer.name());
    glViewport(0, 0, width, height);
}

void MultisampledTarget::end(GLuint to, int x, int y) const {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, buffers_->framebuffer.name());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, to);
    glBlitFramebuffer(0, 0, buffers_->width, buffers_->height, x, y, x + buffers_->width,
                      y + buffers_->height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, to);
}

} // namespace springdrive::app

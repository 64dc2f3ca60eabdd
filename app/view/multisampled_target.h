// A framebuffer with several samples per pixel, for the scene alone: edges are smooth, and panels
// and text, most of the window, cost no more than before.
#pragma once

#include "app/view/gl_objects.h"

#include <memory>

namespace springdrive::app {

class MultisampledTarget {
public:
    /// @param samples  per pixel, as far as OpenGL has them; 0 for a plain framebuffer
    explicit MultisampledTarget(int samples) : samples_(samples) {}

    /// Binds it to be drawn into, with this size. Its contents are undefined.
    /// @throw std::runtime_error if OpenGL cannot draw into it
    void begin(int width, int height);

    /// Copies it, each pixel the mean of its samples, into the framebuffer `to`, which is bound
    /// afterwards. @param x, y  lower left corner there
    void end(GLuint to, int x, int y) const;

private:
    struct Buffers {
        Buffers(int samples, int width, int height);

        Framebuffer framebuffer;
        Renderbuffer colour;
        Renderbuffer depth;
        int width;
        int height;
    };

    int samples_;
    std::unique_ptr<Buffers> buffers_; ///< of the size that was used last
};

} // namespace springdrive::app

// A current OpenGL context without a visible window, for tests that draw.
#pragma once

#include "tests/support/virtual_display.h"

struct GLFWwindow;

namespace springdrive::testing {

/// OpenGL 3.3 core on a virtual display of its own.
class HiddenWindow {
public:
    /// @throw std::runtime_error  there is no Xvfb, or no such OpenGL
    HiddenWindow();
    ~HiddenWindow();
    HiddenWindow(const HiddenWindow &) = delete;
    HiddenWindow &operator=(const HiddenWindow &) = delete;

private:
    VirtualDisplay display_;
    GLFWwindow *window_ = nullptr;
};

} // namespace springdrive::testing

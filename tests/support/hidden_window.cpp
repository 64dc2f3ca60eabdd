#include "tests/support/hidden_window.h"

#include <GLFW/glfw3.h>

#include <cstdlib>
#include <stdexcept>

namespace springdrive::testing {

HiddenWindow::HiddenWindow() : display_(64, 64) {
    setenv("DISPLAY", display_.name().c_str(), 1);
    if (glfwInit() == GLFW_FALSE) {
        throw std::runtime_error("GLFW does not start on the virtual display");
    }
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    window_ = glfwCreateWindow(64, 64, "test", nullptr, nullptr);
    if (window_ == nullptr) {
        glfwTerminate();
        throw std::runtime_error("the virtual display has no OpenGL 3.3");
    }
    glfwMakeContextCurrent(window_);
}

HiddenWindow::~HiddenWindow() {
    glfwDestroyWindow(window_);
    glfwTerminate();
}

} // namespace springdrive::testing

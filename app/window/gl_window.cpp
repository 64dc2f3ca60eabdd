#include "app/window/gl_window.h"

#include "app/host/software_renderer.h"
#include "base/input_error.h"

#include <epoxy/gl.h>
// epoxy must come before GLFW, which would bring in another OpenGL header.
#include <GLFW/glfw3.h>

#include <algorithm>

namespace springdrive::app {

namespace {

/// The last error of GLFW.
std::string &glfw_error() {
    static std::string error;
    return error;
}

void on_glfw_error(int code, const char *text) {
    glfw_error() = std::string(text) + " (GLFW " + std::to_string(code) + ")";
}

} // namespace

GlWindow::GlWindow(const std::string &title, Size size, bool stays) {
    glfwSetErrorCallback(on_glfw_error);
    if (glfwInit() == GLFW_FALSE) {
        throw InputError(
            "no display: " + glfw_error() +
            "; start it from a desktop, or with xvfb-run on a virtual display, as ./app/run does");
    }
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    glfwWindowHint(GLFW_SAMPLES, 0); // the scene has its own, see MultisampledTarget
    glfwWindowHint(GLFW_AUTO_ICONIFY, stays ? GLFW_FALSE : GLFW_TRUE);
    window_ = glfwCreateWindow(size.width, size.height, title.c_str(), nullptr, nullptr);
    if (window_ == nullptr) {
        const std::string why = glfw_error();
        if (count_ == 0) {
            glfwTerminate();
        }
        throw InputError("no window with OpenGL 3.3: " + why +
                         "; install the graphics driver, or libgl1-mesa-dri for software OpenGL");
    }
    ++count_;
}

GlWindow::~GlWindow() {
    glfwDestroyWindow(window_);
    if (--count_ == 0) {
        glfwTerminate();
    }
}

bool GlWindow::draws_in_software() {
    const auto *renderer = reinterpret_cast<const char *>(glGetString(GL_RENDERER));
    return renderer != nullptr && is_software_renderer(renderer);
}

bool GlWindow::has_focus() const {
    return glfwGetWindowAttrib(window_, GLFW_FOCUSED) != GLFW_FALSE;
}

bool GlWindow::is_full_screen() const { return glfwGetWindowMonitor(window_) != nullptr; }

GlWindow::Size GlWindow::framebuffer() const {
    Size pixels;
    glfwGetFramebufferSize(window_, &pixels.width, &pixels.height);
    return pixels;
}

GlWindow::Size GlWindow::size() const {
    Size units;
    glfwGetWindowSize(window_, &units.width, &units.height);
    return units;
}

float GlWindow::pixel_scale() const {
    return static_cast<float>(framebuffer().width) / static_cast<float>(std::max(1, size().width));
}

} // namespace springdrive::app

#include "app/doctor/trial.h"

#include <GLFW/glfw3.h>

#include <string>

namespace springdrive::app::doctor {

namespace {

// Of OpenGL's registry. epoxy, which the window uses, ends the process where a library is missing.
constexpr unsigned kRenderer = 0x1F01;
constexpr unsigned kVersion = 0x1F02;

std::string &last_complaint() {
    static std::string complaint;
    return complaint;
}

void note_complaint(int /*code*/, const char *text) { last_complaint() = text; }

std::string text_of_context(unsigned name) {
    using GetString = const unsigned char *(*)(unsigned);
    const auto get = reinterpret_cast<GetString>(glfwGetProcAddress("glGetString"));
    const unsigned char *const text = get != nullptr ? get(name) : nullptr;
    return text != nullptr ? reinterpret_cast<const char *>(text) : "";
}

GLFWwindow *open_hidden(bool is_as_in_demo) {
    glfwDefaultWindowHints();
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    if (is_as_in_demo) {
        glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
        glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
        glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    }
    return glfwCreateWindow(64, 64, "springdrive doctor", nullptr, nullptr);
}

} // namespace

PictureTrial try_picture() {
    PictureTrial trial;
    glfwSetErrorCallback(note_complaint);
    if (glfwInit() == GLFW_FALSE) {
        trial.display_problem = last_complaint();
        return trial;
    }
    GLFWwindow *window = open_hidden(true);
    if (window == nullptr) {
        trial.window_problem = last_complaint();
        window = open_hidden(false); // any, to name its version
    }
    if (window != nullptr) {
        glfwMakeContextCurrent(window);
        trial.version = text_of_context(kVersion);
        trial.renderer = text_of_context(kRenderer);
    }
    return trial; // its process ends: drivers that crash while being unloaded are not asked to
}

} // namespace springdrive::app::doctor

// What the window needs: a display, and OpenGL on it. Tried, and judged.
#include "app/doctor/checks.h"

#include "app/host/software_renderer.h"

#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <string>
#include <utility>

namespace springdrive::app::doctor {

namespace {

/// "a virtual one", by the shortest line that this computer has.
std::string virtual_display(const Evidence &evidence) {
    const std::filesystem::path script = evidence.process.setup_folder.parent_path() / "app/run";
    std::error_code unreadable;
    if (std::filesystem::exists(script, unreadable)) {
        return shell_word(script.string()) +
               "  # starts a virtual display, and installs it if necessary";
    }
    const std::string run = "xvfb-run -a -s '-screen 0 1280x800x24' springdrive";
    const bool has_it = evidence.machine.is_program("/usr/bin/xvfb-run");
    return has_it ? run : install_line(evidence.machine, evidence.process, "xvfb") + " && " + run;
}

/// ":1" or ":1.0" of this computer is the socket X1.
std::string socket_of(const std::string &display) {
    const std::size_t digits = display.find_first_not_of("0123456789", 1);
    return display.size() > 1 && display.front() == ':'
               ? "/tmp/.X11-unix/X" +
                     display.substr(1, digits == std::string::npos ? digits : digits - 1)
               : "";
}

Finding display(const Evidence &evidence) {
    const PictureProbe &probe = evidence.probes.picture;
    const Process &process = evidence.process;
    const std::string name = process.variable("DISPLAY");
    if (probe.has_answered && probe.display_problem.empty()) {
        return {Verdict::ok, name};
    }
    if (!probe.has_answered) {
        // An OpenGL driver that ends its process has got beyond the display.
        return {Verdict::failure,
                fmt::format("{}: a window there did not open in {:.1f} s, or ended its program",
                            name.empty() ? "DISPLAY is not set" : "DISPLAY=" + name,
                            1e-3 * static_cast<double>(kProbeTime.count())),
                virtual_display(evidence)};
    }
    if (name.empty() && !process.variable("WAYLAND_DISPLAY").empty()) {
        return {Verdict::failure, "only Wayland: DISPLAY is not set, and this window is one of X11",
                install_line(evidence.machine, process, "xwayland") + "  # then log in again"};
    }
    if (name.empty()) {
        return {Verdict::failure, "none: DISPLAY is not set",
                !process.variable("SSH_CONNECTION").empty() ? "connect again by: ssh -X"
                                                            : virtual_display(evidence)};
    }
    const std::string socket = socket_of(name);
    const bool is_there = !socket.empty() && evidence.machine.exists(socket);
    return {Verdict::failure, fmt::format("DISPLAY={}: {}", name, probe.display_problem),
            is_there ? "xhost +si:localuser:$(id -un)  # by the person at that display"
                     : virtual_display(evidence)};
}

/// Settings by which Mesa is told to do with less than it could.
std::string settings_of_mesa(const Process &process) {
    std::string names;
    for (const auto &[name, value] : process.environment) {
        if (name.starts_with("LIBGL_") || name.starts_with("MESA_") || name == "GALLIUM_DRIVER" ||
            name == "__GLX_VENDOR_LIBRARY_NAME") {
            names += " " + name;
        }
    }
    return names;
}

Finding opengl(const Evidence &evidence) {
    const PictureProbe &probe = evidence.probes.picture;
    if (probe.has_answered && !probe.display_problem.empty()) {
        return {Verdict::not_applicable, "no display to try it on"};
    }
    const std::string version =
        probe.version.empty() ? "none" : probe.version + " on " + probe.renderer;
    if (!probe.has_answered || !probe.window_problem.empty()) {
        const std::string settings = settings_of_mesa(evidence.process);
        return {Verdict::failure,
                !probe.has_answered
                    ? "a window did not open in time, or its driver ended the program"
                    : fmt::format("{}: {}", version, probe.window_problem),
                !settings.empty()
                    ? "unset" + settings
                    : install_line(evidence.machine, evidence.process, "libgl1 libgl1-mesa-dri")};
    }
    const bool is_software = is_software_renderer(probe.renderer);
    return {Verdict::ok,
            version + (is_software
                           ? "; drawn by the processor: half a core or more, and fewer frames"
                           : "")};
}

/// Without a window, nothing has to be done.
Finding if_window(const Evidence &evidence, Finding finding) {
    if (!evidence.purpose.has_window && finding.verdict != Verdict::ok) {
        return {Verdict::not_applicable, std::move(finding.found)};
    }
    return finding;
}

// Of OpenGL's registry. epoxy, which the window uses, ends the process where a library is missing.
constexpr unsigned kRenderer = 0x1F01;
constexpr unsigned kVersion = 0x1F02;

std::string &last_error() {
    static std::string error;
    return error;
}

void note_error(int /*code*/, const char *text) { last_error() = text; }

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

PictureProbe try_picture() {
    PictureProbe probe;
    glfwSetErrorCallback(note_error);
    if (glfwInit() == GLFW_FALSE) {
        probe.display_problem = last_error();
        return probe;
    }
    GLFWwindow *window = open_hidden(true);
    if (window == nullptr) {
        probe.window_problem = last_error();
        window = open_hidden(false); // any, to name its version
    }
    if (window != nullptr) {
        glfwMakeContextCurrent(window);
        probe.version = text_of_context(kVersion);
        probe.renderer = text_of_context(kRenderer);
    }
    return probe; // its process ends: drivers that crash while being unloaded are not asked to
}

Finding display_check(const Evidence &evidence) { return if_window(evidence, display(evidence)); }

Finding opengl_check(const Evidence &evidence) { return if_window(evidence, opengl(evidence)); }

} // namespace springdrive::app::doctor

// What the window needs: a display, and OpenGL on it.
#include "app/doctor/checks.h"

#include "app/host/software_renderer.h"

#include <fmt/format.h>

#include <string>

namespace springdrive::app::doctor {

namespace {

constexpr const char *kMattersWindow =
    "only the window (demo) needs it; all other commands do without";

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

Check display(const Evidence &evidence) {
    const PictureTrial &trial = evidence.trials.picture;
    const Process &process = evidence.process;
    const std::string name = process.variable("DISPLAY");
    Check check{"display", "display", Verdict::ok, name, kMattersWindow, ""};
    if (trial.has_answered && trial.display_problem.empty()) {
        return check;
    }
    check.verdict = Verdict::failure;
    if (!trial.has_answered) {
        // An OpenGL driver that ends its process has got beyond the display.
        check.found =
            fmt::format("{}: a window there did not open in {:.1f} s, or ended its program",
                        name.empty() ? "DISPLAY is not set" : "DISPLAY=" + name,
                        1e-3 * static_cast<double>(kTrialTime.count()));
        check.mend = virtual_display(evidence);
        return check;
    }
    if (name.empty()) {
        check.found = process.variable("WAYLAND_DISPLAY").empty()
                          ? "none: DISPLAY is not set"
                          : "only Wayland: DISPLAY is not set, and this window is one of X11";
        check.mend =
            !process.variable("WAYLAND_DISPLAY").empty()
                ? install_line(evidence.machine, process, "xwayland") + "  # then log in again"
            : !process.variable("SSH_CONNECTION").empty() ? "connect again by: ssh -X"
                                                          : virtual_display(evidence);
        return check;
    }
    const std::string socket = socket_of(name);
    const bool is_there = !socket.empty() && evidence.machine.exists(socket);
    check.found = fmt::format("DISPLAY={}: {}", name, trial.display_problem);
    check.mend = is_there ? "xhost +si:localuser:$(id -un)  # by the person at that display"
                          : virtual_display(evidence);
    return check;
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

Check opengl(const Evidence &evidence) {
    const PictureTrial &trial = evidence.trials.picture;
    Check check{"opengl", "OpenGL", Verdict::ok, "", "the window draws with OpenGL 3.3", ""};
    if (trial.has_answered && !trial.display_problem.empty()) {
        check.verdict = Verdict::not_applicable;
        check.found = "no display to try it on";
        return check;
    }
    check.found = trial.version.empty() ? "none" : trial.version + " on " + trial.renderer;
    if (!trial.has_answered || !trial.window_problem.empty()) {
        check.verdict = Verdict::failure;
        check.found = !trial.has_answered
                          ? "a window did not open in time, or its driver ended the program"
                          : fmt::format("{}: {}", check.found, trial.window_problem);
        const std::string settings = settings_of_mesa(evidence.process);
        check.mend = !settings.empty() ? "unset" + settings
                                       : install_line(evidence.machine, evidence.process,
                                                      "libgl1 libgl1-mesa-dri");
        return check;
    }
    if (is_software_renderer(trial.renderer)) {
        check.found += "; drawn by the processor: half a core or more, and fewer frames";
    }
    return check;
}

} // namespace

std::vector<Check> picture_checks(const Evidence &evidence) {
    std::vector<Check> checks{display(evidence), opengl(evidence)};
    if (!evidence.purpose.has_window) {
        for (Check &check : checks) {
            check.verdict = check.verdict == Verdict::ok ? Verdict::ok : Verdict::not_applicable;
            check.mend.clear();
        }
    }
    return checks;
}

} // namespace springdrive::app::doctor

#include "app/study/participant/monitors.h"

#include "app/study/participant/participant_input.h"
#include "base/input_error.h"
#include "base/number_in.h"

#include <GLFW/glfw3.h>

#include <optional>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

std::string all_lines(std::span<const MonitorFacts> monitors) {
    std::string all;
    for (std::size_t i = 0; i < monitors.size(); ++i) {
        all += (i > 0 ? ", " : "") + monitor_line(i, monitors[i]);
    }
    return all.empty() ? "none" : all;
}

std::span<GLFWmonitor *const> glfw_monitors() {
    int count = 0;
    GLFWmonitor *const *const first = glfwGetMonitors(&count);
    return {first, static_cast<std::size_t>(count)};
}

} // namespace

std::string monitor_line(std::size_t index, const MonitorFacts &monitor) {
    return std::to_string(index + 1) + ": " + monitor.name + " " + std::to_string(monitor.width) +
           "×" + std::to_string(monitor.height);
}

std::size_t monitor_meant(std::string_view wish, std::span<const MonitorFacts> monitors) {
    const auto error = [&](const std::string &what) {
        return InputError("no monitor \"" + std::string(wish) + "\" for the participant: " + what +
                          "; there are " + all_lines(monitors));
    };
    if (const std::optional<std::size_t> number = number_in<std::size_t>(wish)) {
        if (*number < 1 || *number > monitors.size()) {
            throw error("numbers are from 1 to " + std::to_string(monitors.size()));
        }
        return *number - 1;
    }
    const std::string part = input_name(wish);
    std::optional<std::size_t> meant;
    for (std::size_t i = 0; i < monitors.size(); ++i) {
        const std::string name = input_name(monitors[i].name);
        if (name == part) {
            return i;
        }
        if (!part.empty() && name.find(part) != std::string::npos) {
            if (meant) {
                throw error("it is part of more than one name");
            }
            meant = i;
        }
    }
    if (!meant) {
        throw error("type its number or a part of its name");
    }
    return *meant;
}

std::vector<MonitorFacts> monitors_there() {
    std::vector<MonitorFacts> all;
    for (GLFWmonitor *const monitor : glfw_monitors()) {
        const GLFWvidmode *const mode = glfwGetVideoMode(monitor);
        const char *const name = glfwGetMonitorName(monitor);
        MonitorFacts facts{name != nullptr ? name : "", mode != nullptr ? mode->width : 0,
                           mode != nullptr ? mode->height : 0};
        glfwGetMonitorPhysicalSize(monitor, &facts.width_mm, &facts.height_mm);
        all.push_back(std::move(facts));
    }
    return all;
}

GLFWmonitor *monitor_named(const std::string &name) {
    for (GLFWmonitor *const monitor : glfw_monitors()) {
        const char *const its_name = glfwGetMonitorName(monitor);
        if (its_name != nullptr && name == its_name) {
            return monitor;
        }
    }
    return nullptr;
}

} // namespace springdrive::app::study_screen

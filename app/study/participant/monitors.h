// The computer's monitors: what they are called, and which one is meant.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

struct GLFWmonitor;

namespace springdrive::app::study_screen {

struct MonitorFacts {
    std::string name; ///< of the connector, such as "HDMI-1"
    int width = 0;    ///< in pixels, as it is set now
    int height = 0;
    int width_mm = 0; ///< as it says itself; 0: not known
    int height_mm = 0;

    friend bool operator==(const MonitorFacts &, const MonitorFacts &) = default;
};

/// Such as "2: HDMI-1 1920×1080".
[[nodiscard]] std::string monitor_line(std::size_t index, const MonitorFacts &monitor);

/// Index of the monitor that is meant by a number from 1, or a name, or a part of one without
/// regard to the case of ASCII letters.
/// @throw InputError if none is meant, or more than one, naming those there are
[[nodiscard]] std::size_t monitor_meant(std::string_view wish,
                                        std::span<const MonitorFacts> monitors);

// @pre of the following: GLFW is initialised

[[nodiscard]] std::vector<MonitorFacts> monitors_there();
/// Null if there is none of that name now.
[[nodiscard]] GLFWmonitor *monitor_named(const std::string &name);

} // namespace springdrive::app::study_screen

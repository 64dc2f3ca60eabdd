// A virtual display with monitors that are plugged in and pulled out. Xvfb has one only; Xorg with
// its driver "dummy" has sixteen, DUMMY0 and so on, of which the first is there from the start.
#pragma once

#include "tests/support/virtual_display.h"

#include <filesystem>
#include <string>

namespace springdrive::testing {

class PluggedMonitors {
public:
    /// The first monitor has 1024 × 768 pixels.
    /// @param folder  for the server's files
    /// @throw std::runtime_error  there is no such server here
    explicit PluggedMonitors(const std::filesystem::path &folder);

    /// Of so many pixels, to the right of the first.
    /// @throw std::runtime_error  the display refuses
    void plug(int monitor, int width, int height);
    void pull(int monitor);

    [[nodiscard]] const VirtualDisplay &display() const { return display_; }

private:
    void set(const std::string &arguments) const;

    VirtualDisplay display_;
};

} // namespace springdrive::testing

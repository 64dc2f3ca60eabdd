// A screen of its own for a test: an X server without hardware.
#pragma once

#include <string>
#include <sys/types.h>
#include <vector>

namespace springdrive::testing {

/// The process of a server, usually Xvfb, which ends with this object and with the thread that
/// created it. Tests that run in parallel have one each. There is no window manager: windows appear
/// at the top left, and nothing gives them the keyboard focus.
class VirtualDisplay {
public:
    /// @throw std::runtime_error  Xvfb is not installed, or does not start within 30 s
    VirtualDisplay(int width, int height);
    /// @param server  program and arguments, to which -displayfd is added
    /// @throw std::runtime_error  the same of this server
    explicit VirtualDisplay(std::vector<std::string> server);
    ~VirtualDisplay();
    VirtualDisplay(const VirtualDisplay &) = delete;
    VirtualDisplay &operator=(const VirtualDisplay &) = delete;

    /// For the variable DISPLAY, such as ":7".
    [[nodiscard]] const std::string &name() const { return name_; }

    /// Its programs wait for answers until it goes on.
    void freeze() const;
    void go_on() const;

private:
    pid_t server_ = -1;
    std::string name_;
};

} // namespace springdrive::testing

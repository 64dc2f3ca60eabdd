// The doctor in the window: offered where something is refused, shown over the panels.
#pragma once

#include "app/doctor/check.h"
#include "base/background.h"
#include "engine/session/session.h"

#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

/// As --device names it.
[[nodiscard]] std::string name_of(const session::DeviceChoice &choice);

/// Asks in the background, so that frames go on.
class DoctorPopup {
public:
    /// A small button beside an error, which asks.
    /// @param device  what is to be used, as --device names it
    void offer(const std::string &device, double servo_hz);

    /// Opens the popup, and fills it when the answer comes.
    void ask(const std::string &device, double servo_hz);

    /// The popup, if it is open: once a frame.
    void draw();

private:
    Background<std::vector<doctor::Check>> asking_;
    std::optional<std::vector<doctor::Check>> checks_;
    std::string error_;
    bool opens_ = false;
};

} // namespace springdrive::app

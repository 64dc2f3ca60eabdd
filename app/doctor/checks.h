// All checks: each judges the same evidence, and reads nothing but what that holds.
#pragma once

#include "app/doctor/check.h"
#include "app/doctor/machine.h"
#include "app/doctor/probe.h"

#include <string>
#include <vector>

namespace springdrive::app::doctor {

struct Evidence {
    Machine machine;
    Process process;
    Purpose purpose;
    Probes probes;
};

/// In the order of the report.
[[nodiscard]] std::vector<Check> all_checks(const Evidence &evidence);

/// Whether a board is there; then, for each that is meant, permission, firmware, speed, autosuspend
/// and hubs.
[[nodiscard]] std::vector<Check> usb_checks(const Evidence &evidence);

/// The line of setup/70-springdrive-usb.rules: of a device with a board's numbers and its
/// interface, for the person at the screen.
[[nodiscard]] std::string udev_rule();

// What the other checks find:

[[nodiscard]] Finding priority_check(const Evidence &evidence);
[[nodiscard]] Finding memory_lock_check(const Evidence &evidence);
[[nodiscard]] Finding real_time_share_check(const Evidence &evidence);
[[nodiscard]] Finding preemption_check(const Evidence &evidence);
[[nodiscard]] Finding idle_check(const Evidence &evidence);
[[nodiscard]] Finding governor_check(const Evidence &evidence);
[[nodiscard]] Finding display_check(const Evidence &evidence);
[[nodiscard]] Finding opengl_check(const Evidence &evidence);
[[nodiscard]] Finding disk_check(const Evidence &evidence);
[[nodiscard]] Finding gnuplot_check(const Evidence &evidence);
[[nodiscard]] Finding font_check(const Evidence &evidence);

} // namespace springdrive::app::doctor

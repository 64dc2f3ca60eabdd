// All checks: each judges the same evidence. None reads anything but what the evidence holds.
#pragma once

#include "app/doctor/check.h"
#include "app/doctor/machine.h"
#include "app/doctor/trial.h"

#include <algorithm>
#include <iterator>
#include <vector>

namespace springdrive::app::doctor {

struct Evidence {
    Machine machine;
    Process process;
    Purpose purpose;
    Trials trials;
};

/// Priority, memory lock, the kernel's share for real-time threads, its preemption, idle states,
/// frequency.
[[nodiscard]] std::vector<Check> servo_checks(const Evidence &evidence);

[[nodiscard]] Check priority_check(const Evidence &evidence);
[[nodiscard]] Check memory_lock_check(const Evidence &evidence);
[[nodiscard]] Check real_time_share_check(const Evidence &evidence);
[[nodiscard]] Check preemption_check(const Evidence &evidence);
[[nodiscard]] Check idle_check(const Evidence &evidence);
[[nodiscard]] Check governor_check(const Evidence &evidence);

/// Whether a board is there; then, for each that is meant, permission, firmware, speed, autosuspend
/// and hubs.
[[nodiscard]] std::vector<Check> usb_checks(const Evidence &evidence);

/// Display and OpenGL.
[[nodiscard]] std::vector<Check> picture_checks(const Evidence &evidence);

[[nodiscard]] Check disk_check(const Evidence &evidence);

/// What springdrive starts or loads while it runs: gnuplot, the font.
[[nodiscard]] std::vector<Check> package_checks(const Evidence &evidence);

[[nodiscard]] inline std::vector<Check> all_checks(const Evidence &evidence) {
    std::vector<Check> all;
    for (auto *const make : {&servo_checks, &usb_checks, &picture_checks}) {
        std::ranges::move((*make)(evidence), std::back_inserter(all));
    }
    all.push_back(disk_check(evidence));
    std::ranges::move(package_checks(evidence), std::back_inserter(all));
    return all;
}

} // namespace springdrive::app::doctor

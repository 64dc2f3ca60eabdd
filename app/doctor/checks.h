// What the doctor finds out about a computer: a list of checks, each a value; how each is made from
// the same evidence, reading nothing but what that holds; and their report, for people and for
// programs, and for a program that already runs, with its threads and its window.
#pragma once

#include "app/doctor/evidence.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app::doctor {

enum class Verdict : std::uint8_t {
    ok,
    warning,        ///< springdrive runs, but worse than it could
    failure,        ///< what it is to be used for does not work
    not_applicable, ///< not needed, or not to be seen on this computer
};
inline constexpr std::array<std::string_view, 4> kVerdictNames{"ok", "warning", "failure",
                                                               "not applicable"};

[[nodiscard]] inline std::string_view name_of(Verdict verdict) {
    return kVerdictNames.at(static_cast<std::size_t>(verdict));
}

struct Finding {
    Verdict verdict = Verdict::ok;
    std::string found; ///< with numbers and units
    std::string fix{}; ///< the one line, for a shell or a person; empty if nothing is to be done
};

struct Check : Finding {
    std::string id; ///< for scripts; several boards have checks of the same ids
    std::string title;
    std::string matters; ///< why, in a few words
};

/// What springdrive is to be used for, by which the same finding is judged.
struct Purpose {
    double servo_hz = 1000.0;
    bool uses_usb = false;
    std::string serial; ///< of a board; empty: the only one
    bool has_window = true;
    std::filesystem::path folder = "."; ///< of records

    /// Of what merely makes the simulated device pause, but stops a real one in a person's hand.
    [[nodiscard]] Verdict worse_with_usb() const {
        return uses_usb ? Verdict::failure : Verdict::warning;
    }
};

[[nodiscard]] inline std::size_t count_of(const std::vector<Check> &checks, Verdict verdict) {
    return static_cast<std::size_t>(std::ranges::count(checks, verdict, &Check::verdict));
}

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

struct DoctorReport {
    std::string version; ///< of springdrive
    std::string machine; ///< its processor
    Purpose purpose;
    std::vector<Check> checks;

    [[nodiscard]] bool is_healthy() const { return count_of(checks, Verdict::failure) == 0; }
};

void write_text(std::ostream &out, const DoctorReport &report);
void write_json(std::ostream &out, const DoctorReport &report);

/// The checks of a report in JSON.
/// @throw InputError for what is no such report
[[nodiscard]] std::vector<Check> checks_in(std::string_view json);

/// Runs `springdrive doctor` as a program of its own, for at most some three seconds.
/// @param device  as --device names it
/// @throw InputError if it cannot be run
[[nodiscard]] std::vector<Check> ask_doctor(const std::string &device, double servo_hz);

} // namespace springdrive::app::doctor

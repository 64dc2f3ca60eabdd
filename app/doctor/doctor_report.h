// The doctor's report, for people and for programs; and for a program that already runs, with its
// threads and its window.
#pragma once

#include "app/doctor/check.h"

#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app::doctor {

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

// The doctor's report, for people and for programs.
#pragma once

#include "app/doctor/check.h"

#include <iosfwd>
#include <string>
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

} // namespace springdrive::app::doctor

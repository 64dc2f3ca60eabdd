// Where methods fail, each limit predicted and measured: the table of docs/stability.md.
#pragma once

#include "engine/lab/limits/failure_lines/failure_line.h"
#include "engine/lab/loops/stability_case.h"

#include <ostream>

namespace springdrive::limits {

/// Every method of the design, on one device.
/// @param which  its device, configuration and hands are used; each row has its own tuning
/// @param progress  receives a share from 0 to 1
[[nodiscard]] std::vector<FailureLine> failure_lines(const loops::StabilityCase &which,
                                                     const std::function<void(double)> &progress);

/// The rows found by trials, not measured yet: all except the limits of sampled loops.
[[nodiscard]] std::vector<TriedLine> tried_lines(const loops::StabilityCase &which);

/// As a Markdown table with four digits.
void write_failure_lines(std::ostream &out, const std::vector<FailureLine> &lines);

/// The same table as CSV, with all digits.
void write_failure_lines_csv(std::ostream &out, const std::vector<FailureLine> &lines);

} // namespace springdrive::limits

// Where methods fail, each limit predicted and measured: the table of docs/stability.md.
#pragma once

#include "engine/lab/limits/method_limits/method_limit.h"
#include "engine/lab/loops/stability_case.h"

#include <ostream>

namespace springdrive::limits {

/// Every method of the design, on one device.
/// @param which  its device, configuration and hands are used; each row has its own tuning
/// @param progress  receives a share from 0 to 1
[[nodiscard]] std::vector<MethodLimit> method_limits(const loops::StabilityCase &which,
                                                     const std::function<void(double)> &progress);

/// The rows found by trials, not measured yet: all except the limits of sampled loops.
[[nodiscard]] std::vector<LimitTrial> limit_trials(const loops::StabilityCase &which);

/// As a Markdown table with four digits.
void write_method_limits(std::ostream &out, const std::vector<MethodLimit> &lines);

/// The same table as CSV, with all digits.
void write_method_limits_csv(std::ostream &out, const std::vector<MethodLimit> &lines);

} // namespace springdrive::limits

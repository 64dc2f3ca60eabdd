// Where methods fail, each limit predicted and measured: the table of docs/stability.md.
#pragma once

#include "base/table.h"
#include "engine/lab/limits/method_limits/method_limit.h"
#include "engine/lab/loops/stability_case.h"

#include <functional>
#include <vector>

namespace springdrive::limits {

/// Every method of the design, on one device.
/// @param which  its device, configuration and hands are used; each row has its own tuning
/// @param progress  receives a share from 0 to 1
[[nodiscard]] std::vector<MethodLimit> method_limits(const loops::StabilityCase &which,
                                                     const std::function<void(double)> &progress);

/// The rows found by trials, not measured yet: all except the limits of sampled loops.
[[nodiscard]] std::vector<LimitTrial> limit_trials(const loops::StabilityCase &which);

/// For documents, with four digits.
[[nodiscard]] Table method_limits_document(const std::vector<MethodLimit> &lines);

/// For programs, with all digits.
[[nodiscard]] Table method_limits_table(const std::vector<MethodLimit> &lines);

} // namespace springdrive::limits

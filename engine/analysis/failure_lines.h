// Where methods fail, each line predicted and measured: the table of docs/stability.md.
#pragma once

#include "engine/analysis/stability/stability_case.h"

#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace springdrive {

/// One row.
struct FailureLine {
    std::string method;
    std::string fails; ///< "K_P above"
    std::string unit;
    std::string setting; ///< what else it depends on
    std::optional<double> predicted;
    std::optional<double> measured;          ///< without what the prediction does not know
    std::optional<double> measured_as_it_is; ///< with counts, supply and friction
};

/// Every method of the design, on one device.
/// @param which  its device, configuration and hands; tunings are those of each row
/// @param progress  told a share from 0 to 1
[[nodiscard]] std::vector<FailureLine> failure_lines(const StabilityCase &which,
                                                     const std::function<void(double)> &progress);

/// As a Markdown table.
void write_failure_lines(std::ostream &out, const std::vector<FailureLine> &lines);

} // namespace springdrive

// Where methods fail: experiments that find each limit in the running code, beside its prediction.
// The table of docs/stability.md.
#pragma once

#include "base/table.h"
#include "engine/lab/loops/stability_case.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::limits {

/// One row of the table.
struct MethodLimit {
    std::string method;
    std::string fails; ///< "K_P above"
    std::string unit;
    std::string setting; ///< what else it depends on, or the range tried without a failure
    std::optional<double> predicted{};
    std::optional<double> measured{};          ///< only with effects that the prediction includes
    std::optional<double> measured_as_it_is{}; ///< with counts, supply and friction
};

/// The values to search for a limit.
struct TriedValues {
    double holds_at = 0.0;    ///< from here
    double fails_at = 0.0;    ///< to here
    bool whole = false;       ///< only whole numbers can be tried
    double resolution = 1e-6; ///< relative resolution of the search
};

/// A parameter of sampled loops along which they become unstable.
struct LoopSweep {
    loops::StabilityCase which;
    const loops::StabilityParameter *parameter = nullptr;
};

/// Rows that are not measured yet: their prediction and the run that finds them. Values are in the
/// row's unit.
struct Experiment {
    MethodLimit row;
    TriedValues tried{};
    std::function<bool(double)> holds{};
    /// Instead of the above, for a row that is a value rather than a limit.
    std::function<std::optional<double>()> reading{};
    /// Instead of all of these: a row for each limit that `stability_limits` finds.
    std::optional<LoopSweep> loop{};
};

/// Every method of the design, on one device.
/// @param which  its device, configuration and hands are used; each row has its own tuning
[[nodiscard]] std::vector<Experiment> experiments(const loops::StabilityCase &which);

/// The rows of an experiment, measured. Where even `fails_at` holds, values between are tried as
/// well, spaced by equal factors where both ends have the same sign; `measured` is empty where all
/// hold.
[[nodiscard]] std::vector<MethodLimit> measured(const Experiment &experiment);

/// All of them. @param progress  receives a share from 0 to 1
[[nodiscard]] std::vector<MethodLimit> method_limits(const loops::StabilityCase &which,
                                                     const std::function<void(double)> &progress);

/// For documents, with four digits.
[[nodiscard]] Table method_limits_document(const std::vector<MethodLimit> &lines);

/// For programs, with all digits.
[[nodiscard]] Table method_limits_table(const std::vector<MethodLimit> &lines);

} // namespace springdrive::limits

// One limit at which a method fails: its prediction, and the trial that finds it in the running
// code.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::limits {

/// Default relative resolution of the search for a limit.
constexpr double kLimitResolution = 1e-6;

/// One row of the table.
struct MethodLimit {
    std::string method;
    std::string fails; ///< "K_P above"
    std::string unit;
    std::string setting; ///< what else it depends on, or the range tried without a failure
    std::optional<double> predicted;
    std::optional<double> measured;          ///< only with effects that the prediction includes
    std::optional<double> measured_as_it_is; ///< with counts, supply and friction
};

/// A row that is not measured yet. Values are in the row's unit.
struct LimitTrial {
    MethodLimit line;
    double holds_at = 0.0; ///< the search range: from here
    double fails_at = 0.0; ///< to here
    bool whole = false;    ///< only whole numbers can be tried
    std::function<bool(double)> holds{};
    /// Instead of the above, for a row that is a value rather than a limit.
    std::function<std::optional<double>()> reading{};
    double resolution = kLimitResolution; ///< relative resolution of the search
};

/// The row, measured. Where even `fails_at` holds, values between are tried as well, spaced by
/// equal factors where both ends have the same sign; `measured` is empty where all hold.
[[nodiscard]] MethodLimit measured(const LimitTrial &trial);

/// "0.1 Ω".
[[nodiscard]] std::string with_unit(double value, const char *unit);

} // namespace springdrive::limits

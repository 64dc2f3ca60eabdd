// One line at which a method fails: what is predicted, and the trial that finds it in the code that
// runs.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::limits {

/// To so much of its value a line is looked for, where nothing else is said.
constexpr double kLineResolution = 1e-6;

/// One row of the table.
struct FailureLine {
    std::string method;
    std::string fails; ///< "K_P above"
    std::string unit;
    std::string setting; ///< what else it depends on, or what was tried in vain
    std::optional<double> predicted;
    std::optional<double> measured;          ///< without what the prediction does not know
    std::optional<double> measured_as_it_is; ///< with counts, supply and friction
};

/// A row that is not measured yet. Values are in the row's unit.
struct TriedLine {
    FailureLine line;
    double holds_at = 0.0; ///< where to look for the line: from here
    double fails_at = 0.0; ///< to here
    bool whole = false;    ///< only whole numbers can be tried
    std::function<bool(double)> holds{};
    /// In place of the three above, for what is a value rather than a line.
    std::function<std::optional<double>()> reading{};
    double resolution = kLineResolution; ///< to so much of its value the line is looked for
};

/// The row, measured. Where even `fails_at` holds, values between are tried as well, by equal
/// factors where both ends have one sign; nothing is measured where all hold.
[[nodiscard]] FailureLine measured(const TriedLine &tried);

/// "0.1 Ω".
[[nodiscard]] std::string with_unit(double value, const char *unit);

} // namespace springdrive::limits

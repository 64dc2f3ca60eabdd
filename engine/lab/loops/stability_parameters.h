// The parameters of a stability analysis: the list that command line, maps and tables read.
#pragma once

#include "engine/lab/loops/stability_case.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace springdrive::loops {

struct StabilityParameter {
    std::string_view name; ///< on the command line
    std::string_view symbol;
    std::string_view unit; ///< "–" where it has none
    double minimum = 0.0;  ///< of the meaningful range, inclusive
    double maximum = 0.0;
    double from = 0.0; ///< default range of the search for limits
    double to = 0.0;
    bool logarithmic = false;
    double (*get)(const StabilityCase &) = nullptr;
    void (*set)(StabilityCase &, double) = nullptr;
    std::string_view help;
};

[[nodiscard]] std::span<const StabilityParameter> stability_parameters();

/// Null for an unknown name.
[[nodiscard]] const StabilityParameter *stability_parameter_named(std::string_view name);

/// All names, separated by commas.
[[nodiscard]] std::string names_of_stability_parameters();

/// Why the parameter cannot have the value, with its range; empty when it can.
[[nodiscard]] std::string validate(const StabilityParameter &parameter, double value);

} // namespace springdrive::loops

#include "app/commands/model_table.h"

#include "base/degrees.h"
#include "base/print.h"

#include <string>

namespace springdrive::app {

namespace {

/// Whether a candidate is selected, or its verdict in combination with the selected others.
std::string further(const model_selection::ModelAxis &axis, std::size_t candidate,
                    const scene::ModelTolerance &tolerance) {
    if (candidate == axis.chosen) {
        return "  <- selected";
    }
    for (const model_selection::CheaperTrial &trial : axis.cheaper) {
        if (trial.candidate == candidate) {
            return "; with the others selected: " +
                   model_selection::verdict(trial.error, tolerance);
        }
    }
    return "";
}

void write_axis(std::ostream &out, const model_selection::ModelAxis &axis,
                const scene::ModelTolerance &tolerance) {
    for (std::size_t i = 0; i < axis.candidates.size(); ++i) {
        const model_selection::Candidate &candidate = axis.candidates[i];
        print(out, "{:<11}{:<21}{:>9.0f}", i == 0 ? axis.name : "", candidate.name,
              candidate.cost.min_ns);
        print(out, "{:>10.3f}{:>11.2f}  ", candidate.error.force_N,
              candidate.error.direction_rad * kDegreesPerRadian);
        print(out, "{}{}\n", model_selection::verdict(candidate.error, tolerance),
              further(axis, i, tolerance));
    }
}

} // namespace

void write_model_table(std::ostream &out, const model_selection::ModelSelection &choice) {
    const scene::ModelTolerance &tolerance = choice.tolerance;
    print(out, "\nmodel: force to {:.3g} N, direction to {:.3g}°, below {:.3g} Hz\n",
          tolerance.force_N, tolerance.direction_rad * kDegreesPerRadian, tolerance.bandwidth_hz);
    out << "           candidate             cost [ns] force [N] direction [°]\n";
    for (const model_selection::ModelAxis &axis : choice.axes) {
        write_axis(out, axis, tolerance);
    }
    print(out, "selected: error {:.3f} N and {:.2f}° relative to the full model, ",
          choice.error.force_N, choice.error.direction_rad * kDegreesPerRadian);
    print(out, "at {:.2f} µs per tick instead of {:.2f} µs\n", 1e-3 * choice.cost_ns,
          1e-3 * choice.fullest_cost_ns);
    for (const std::string &remark : choice.remarks) {
        out << "remark: " << remark << '\n';
    }
}

} // namespace springdrive::app

// How many trials a precision takes, for people and other programs.
#pragma once

#include "base/table.h"
#include "engine/study/analysis/precision_plan.h"
#include "engine/study/protocol/protocol.h"

#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace springdrive::app {

struct PrecisionPlan {
    study::PsychometricFunction observer; ///< all simulated ones are alike
    study::PrecisionQuestion question;
    std::vector<study::Precision> rows;
    std::optional<double> wanted; ///< width, on the scale
    int usual_trials = 0;         ///< that the protocol takes of such an observer
};

/// A width on the scale, as it is shown: a factor from end to end on a logarithmic one, else in the
/// level's unit.
[[nodiscard]] double shown_width(study::Scale scale, double width);

/// A table, and what the wanted precision takes.
void write_plan(std::ostream &out, const study::Protocol &protocol, const PrecisionPlan &plan);

/// For programs: a row a number of trials; widths and errors on the scale.
[[nodiscard]] Table plan_table(const study::Protocol &protocol, const PrecisionPlan &plan);

/// "observers with threshold 25, slope 2, lapse rate 0.02", for people.
[[nodiscard]] std::string observer_text(const study::PsychometricFunction &observer);

} // namespace springdrive::app

// Results as tables for other programs, a row for each of what is named first below. Levels and
// thresholds are in the unit of what `level_name` says.
#pragma once

#include "base/table.h"
#include "engine/study/results/study_results.h"

#include <array>
#include <string_view>

namespace springdrive::study {

/// Participant and condition: trials, threshold, slope and lapse rate with 95 % intervals, by
/// posterior and maximum likelihood, Weber's fraction, goodness of fit, mean settings.
[[nodiscard]] Table thresholds_table(const Protocol &protocol, const StudyResults &results);

/// Condition: the group's mean threshold.
[[nodiscard]] Table group_table(const Protocol &protocol, const StudyResults &results);

/// Participant, condition and level: trials and positive answers (right, or "yes").
[[nodiscard]] Table levels_table(const Protocol &protocol, const StudyResults &results);

/// Participant, condition and level: the proportions of the fitted functions, the posterior's with
/// its 95 % interval, and maximum likelihood's.
[[nodiscard]] Table functions_table(const Protocol &protocol, const StudyResults &results);

/// Participant, condition, block and trial: level, answer, and what the method made of them.
[[nodiscard]] Table traces_table(const Protocol &protocol, const StudyResults &results);

struct ResultsTable {
    std::string_view file; ///< its name
    Table (*make)(const Protocol &, const StudyResults &);
};

inline constexpr std::array<ResultsTable, 5> kResultsTables{{
    {"thresholds.csv", thresholds_table},
    {"group.csv", group_table},
    {"levels.csv", levels_table},
    {"functions.csv", functions_table},
    {"traces.csv", traces_table},
}};

} // namespace springdrive::study

// Results as tables for other programs: CSV with a header, a row for each of what is named first
// below. Levels and thresholds are in the unit of what `level_name` says; what is not known is an
// empty cell.
#pragma once

#include "engine/study/results/study_results.h"

#include <array>
#include <ostream>
#include <string_view>

namespace springdrive::study {

struct ResultsTable {
    std::string_view file; ///< its name
    void (*write)(std::ostream &, const Protocol &, const StudyResults &);
};

/// Participant and condition: trials, threshold, slope and lapse rate with 95 % intervals, by
/// posterior and maximum likelihood, Weber's fraction, goodness of fit, mean settings.
void write_thresholds_csv(std::ostream &out, const Protocol &protocol, const StudyResults &results);

/// Condition: the group's mean threshold.
void write_group_csv(std::ostream &out, const Protocol &protocol, const StudyResults &results);

/// Participant, condition and level: trials and positive answers (right, or "yes").
void write_levels_csv(std::ostream &out, const Protocol &protocol, const StudyResults &results);

/// Participant, condition and level: the proportions of the fitted functions, the posterior's with
/// its 95 % interval, and maximum likelihood's.
void write_functions_csv(std::ostream &out, const Protocol &protocol, const StudyResults &results);

/// Participant, condition, block and trial: level, answer, and what the method made of them.
void write_traces_csv(std::ostream &out, const Protocol &protocol, const StudyResults &results);

inline constexpr std::array<ResultsTable, 5> kResultsTables{{
    {"thresholds.csv", write_thresholds_csv},
    {"group.csv", write_group_csv},
    {"levels.csv", write_levels_csv},
    {"functions.csv", write_functions_csv},
    {"traces.csv", write_traces_csv},
}};

} // namespace springdrive::study

// Pictures of a study, drawn by assets/figures/study_*.gnuplot from the tables beside them.
#pragma once

#include "app/commands/study/plan_report.h"
#include "app/figures/gnuplot.h"
#include "engine/study/results/study_results.h"

#include <filesystem>
#include <vector>

namespace springdrive::app {

/// The widths of the 95 % interval over the trials: precision.svg, from precision.csv.
[[nodiscard]] Chart plan_picture(const study::Protocol &protocol, const PrecisionPlan &plan,
                                 const std::filesystem::path &folder);

/// Of each participant the fitted functions and the traces of the method, functions_P01.svg and
/// traces_P01.svg, and the group, group.svg; from the tables of results_tables.h. Constant stimuli
/// have no traces worth drawing, adjustments no functions.
[[nodiscard]] std::vector<Chart> results_pictures(const study::Protocol &protocol,
                                                  const study::StudyResults &results,
                                                  const std::filesystem::path &folder);

} // namespace springdrive::app

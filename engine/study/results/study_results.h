// What all trials of a study on one kind of device say.
#pragma once

#include "engine/study/analysis/group_summary.h"
#include "engine/study/results/series_result.h"

#include <functional>
#include <optional>
#include <vector>

namespace springdrive::study {

/// The mean of the participants' thresholds (of an adjustment, of their mean settings) in one
/// condition: `random_effects` on the scale of the function. Participants without an estimate are
/// left out.
struct ConditionSummary {
    std::size_t condition = 0; ///< index into `Protocol::conditions`
    GroupSummary on_scale;
    double mean = 0.0; ///< as levels
    double low = 0.0;
    double high = 0.0;
};

struct StudyResults {
    DeviceKind device = DeviceKind::usb;
    FunctionFamily family; ///< that was fitted; of an adjustment only its scale
    std::vector<SeriesResult> series;
    std::vector<ConditionSummary> conditions;
};

/// Receives the share that is done, from 0 to 1, one call at a time.
using ResultsProgress = std::function<void(double)>;

/// All of them, on all processors.
/// @pre validate(protocol) is empty
[[nodiscard]] StudyResults results_of(const Protocol &protocol, const StudyContents &contents,
                                      DeviceKind device, const ResultsProgress &progress);

} // namespace springdrive::study

#include "engine/study/results/study_results.h"

#include "base/parallel.h"
#include "engine/study/protocol/analysis_plan.h"

#include <mutex>
#include <utility>

namespace springdrive::study {

namespace {

std::optional<ParticipantEstimate> estimate_of(const SeriesResult &result, Scale scale) {
    if (result.settings && result.settings->standard_error_on_scale > 0.0) {
        return ParticipantEstimate{on_scale(scale, result.settings->mean),
                                   result.settings->standard_error_on_scale};
    }
    if (result.fitted && result.fitted->threshold.deviation_on_scale > 0.0) {
        return ParticipantEstimate{on_scale(scale, result.fitted->threshold.mean),
                                   result.fitted->threshold.deviation_on_scale};
    }
    return std::nullopt;
}

std::optional<ConditionSummary> summary_of(const StudyResults &results, std::size_t condition) {
    const Scale scale = results.family.scale;
    std::vector<ParticipantEstimate> estimates;
    for (const SeriesResult &result : results.series) {
        if (result.series.condition == condition) {
            if (const std::optional<ParticipantEstimate> one = estimate_of(result, scale)) {
                estimates.push_back(*one);
            }
        }
    }
    if (estimates.empty()) {
        return std::nullopt;
    }
    const GroupSummary group = random_effects(estimates);
    return ConditionSummary{condition, group, level_from(scale, group.mean),
                            level_from(scale, group.low), level_from(scale, group.high)};
}

} // namespace

StudyResults results_of(const Protocol &protocol, const StudyContents &contents, DeviceKind device,
                        const ResultsProgress &progress) {
    StudyResults results;
    results.device = device;
    results.family = analysis_family(protocol);
    if (const auto *adjustment = std::get_if<Adjustment>(&protocol.method)) {
        results.family.scale = adjustment->scale;
    }
    std::vector<Series> series = series_of(protocol, contents, device);
    results.series.resize(series.size());
    std::mutex counting;
    std::size_t done = 0;
    for_each_in_parallel(series.size(), all_processors(), [&](std::size_t i) {
        results.series[i] = result_of(protocol, std::move(series[i]));
        const std::scoped_lock lock(counting);
        progress(static_cast<double>(++done) / static_cast<double>(series.size()));
    });
    for (std::size_t i = 0; i < protocol.conditions.size(); ++i) {
        if (const std::optional<ConditionSummary> summary = summary_of(results, i)) {
            results.conditions.push_back(*summary);
        }
    }
    return results;
}

} // namespace springdrive::study

#include "engine/study/analysis/direct_estimates.h"

#include "engine/study/methods/random_key.h"

#include <cstddef>

namespace springdrive::study {

std::vector<std::optional<ReversalEstimate>>
reversal_estimates(const Staircases &method, std::span<const PastMethodTrial> trials,
                   int left_out) {
    StaircasesRun run(method, RandomKey{}); // the key draws tracks, which are known by now
    for (const PastMethodTrial &trial : trials) {
        run.add(trial);
    }
    std::vector<std::optional<ReversalEstimate>> estimates;
    for (const StaircaseTrack &track : run.tracks()) {
        const std::ptrdiff_t left = std::ssize(track.reversal_levels) - left_out;
        if (left < 2) {
            estimates.emplace_back();
            continue;
        }
        std::vector<double> on_scales;
        for (const double level :
             std::span(track.reversal_levels).last(static_cast<std::size_t>(left - left % 2))) {
            on_scales.push_back(on_scale(method.scale, level));
        }
        const MeanSummary mean = mean_of(on_scales);
        estimates.push_back(
            ReversalEstimate{level_from(method.scale, mean.mean), mean.deviation, mean.values});
    }
    return estimates;
}

std::optional<MeanSummary> settings_on_scale(const Adjustment &method,
                                             std::span<const PastMethodTrial> trials,
                                             double confidence) {
    std::vector<double> settings;
    for (const PastMethodTrial &trial : trials) {
        if (!trial.outcome.marked) {
            settings.push_back(on_scale(method.scale, trial.outcome.setting));
        }
    }
    return settings.empty() ? std::nullopt : std::optional(mean_of(settings, confidence));
}

} // namespace springdrive::study

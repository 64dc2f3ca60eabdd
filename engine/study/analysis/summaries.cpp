#include "engine/study/analysis/summaries.h"

#include "base/assertions.h"
#include "base/bisection.h"
#include "engine/study/methods/random_key.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <numeric>

namespace springdrive::study {

double student_proportion(double t, int degrees_of_freedom) {
    SPRINGDRIVE_ASSERT(degrees_of_freedom >= 1);
    const double angle = std::atan(t / std::sqrt(degrees_of_freedom));
    const double cosine_squared = std::cos(angle) * std::cos(angle);
    const bool is_odd = degrees_of_freedom % 2 == 1;
    // A(t|ν): an odd ν has cos θ (1 + 2/3 cos² θ + …), an even one 1 + 1/2 cos² θ + …
    double term = is_odd ? std::cos(angle) : 1.0;
    double sum = 0.0;
    for (int i = is_odd ? 3 : 2; i <= degrees_of_freedom; i += 2) {
        sum += term;
        term *= cosine_squared * (i - 1.0) / i;
    }
    const double inside = is_odd ? (angle + std::sin(angle) * sum) * 2.0 * std::numbers::inv_pi
                                 : std::sin(angle) * sum;
    return 0.5 + 0.5 * inside;
}

double student_quantile(double proportion, int degrees_of_freedom) {
    constexpr double kBeyond = 1e9; // of one degree of freedom at 1 − 1e-9: 3e8
    SPRINGDRIVE_ASSERT(proportion >= 0.5 && proportion <= 1.0 - 1e-9);
    constexpr int kHalvings = 100;
    return bisect({0.0, kBeyond}, kHalvings,
                  [&](double t) { return student_proportion(t, degrees_of_freedom) < proportion; })
        .holds_at;
}

MeanSummary mean_of(std::span<const double> values, double confidence) {
    SPRINGDRIVE_ASSERT(!values.empty() && confidence > 0.0 && confidence < 1.0);
    const auto count = static_cast<double>(values.size());
    MeanSummary summary;
    summary.values = static_cast<int>(values.size());
    summary.mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
    if (values.size() == 1) {
        summary.low = -std::numeric_limits<double>::infinity();
        summary.high = std::numeric_limits<double>::infinity();
        return summary;
    }
    double squares = 0.0;
    for (const double value : values) {
        squares += (value - summary.mean) * (value - summary.mean);
    }
    summary.deviation = std::sqrt(squares / (count - 1.0));
    summary.standard_error = summary.deviation / std::sqrt(count);
    const double reach =
        student_quantile(0.5 + 0.5 * confidence, summary.values - 1) * summary.standard_error;
    summary.low = summary.mean - reach;
    summary.high = summary.mean + reach;
    return summary;
}

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

namespace {

struct WeightedMean {
    double mean = 0.0;
    double weights = 0.0;
    double squares = 0.0; ///< Σ w (value − mean)²
};

WeightedMean weighted_mean(std::span<const ParticipantEstimate> estimates, double tau_squared) {
    const auto weight = [&](const ParticipantEstimate &one) {
        return 1.0 / (tau_squared + one.standard_error * one.standard_error);
    };
    WeightedMean result;
    for (const ParticipantEstimate &one : estimates) {
        result.weights += weight(one);
        result.mean += weight(one) * one.value;
    }
    result.mean /= result.weights;
    for (const ParticipantEstimate &one : estimates) {
        result.squares += weight(one) * (one.value - result.mean) * (one.value - result.mean);
    }
    return result;
}

/// τ² of Paule and Mandel; 0 where the estimates scatter less than their errors say.
double tau_squared_of(std::span<const ParticipantEstimate> estimates) {
    const auto expected = static_cast<double>(estimates.size()) - 1.0;
    const auto scatters_more = [&](double tau_squared) {
        return weighted_mean(estimates, tau_squared).squares > expected;
    };
    if (estimates.size() < 2 || !scatters_more(0.0)) {
        return 0.0;
    }
    double beyond = 1e-300;
    for (const ParticipantEstimate &one : estimates) {
        const double off = one.value - estimates.front().value;
        beyond = std::max(beyond, off * off); // w < 1/τ², so the squares are below N − 1 by then
    }
    constexpr int kHalvings = 200;
    return bisect({0.0, 4.0 * beyond}, kHalvings, scatters_more).holds_at;
}

} // namespace

GroupSummary random_effects(std::span<const ParticipantEstimate> estimates, double confidence) {
    SPRINGDRIVE_ASSERT(!estimates.empty() && confidence > 0.0 && confidence < 1.0);
    const double tau_squared = tau_squared_of(estimates);
    const WeightedMean weighted = weighted_mean(estimates, tau_squared);
    GroupSummary summary;
    summary.participants = static_cast<int>(estimates.size());
    summary.mean = weighted.mean;
    summary.deviation_between = std::sqrt(tau_squared);
    summary.heterogeneity = weighted_mean(estimates, 0.0).squares;
    const int degrees_of_freedom = summary.participants - 1;
    double widening = 1.0;
    double t = std::numeric_limits<double>::infinity();
    if (degrees_of_freedom > 0) {
        widening = std::max(1.0, weighted.squares / degrees_of_freedom);
        t = student_quantile(0.5 + 0.5 * confidence, degrees_of_freedom);
    }
    summary.standard_error = std::sqrt(widening / weighted.weights);
    summary.low = summary.mean - t * summary.standard_error;
    summary.high = summary.mean + t * summary.standard_error;
    return summary;
}

} // namespace springdrive::study

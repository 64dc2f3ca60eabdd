#include "engine/study/analysis/group_summary.h"

#include "base/assertions.h"
#include "base/bisection.h"
#include "engine/study/analysis/student.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace springdrive::study {

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

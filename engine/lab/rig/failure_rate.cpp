#include "engine/lab/rig/failure_rate.h"

#include "base/assertions.h"
#include "base/bisection.h"

#include <cmath>

namespace springdrive::rig {

namespace {

/// P(at most `failures` of `trials`), each failing with probability `rate`.
double probability_of_at_most(std::size_t failures, std::size_t trials, double rate) {
    const auto n = static_cast<double>(trials);
    double log_term = n * std::log1p(-rate); // of no failure
    const double log_odds = std::log(rate) - std::log1p(-rate);
    double sum = std::exp(log_term);
    for (std::size_t i = 0; i < failures; ++i) {
        const auto k = static_cast<double>(i);
        log_term += std::log((n - k) / (k + 1.0)) + log_odds;
        sum += std::exp(log_term);
    }
    return sum;
}

} // namespace

std::size_t trials_to_exclude(double rate, double confidence) {
    SPRINGDRIVE_ASSERT(rate > 0.0 && rate < 1.0 && confidence > 0.0 && confidence < 1.0);
    return static_cast<std::size_t>(std::ceil(std::log1p(-confidence) / std::log1p(-rate)));
}

double rate_not_excluded(std::size_t failures, std::size_t trials, double confidence) {
    SPRINGDRIVE_ASSERT(failures <= trials && confidence > 0.0 && confidence < 1.0);
    if (failures == trials) {
        return 1.0; // also without any trial
    }
    constexpr int kHalvings = 100; // rates may be small
    const auto is_likely = [&](double rate) {
        return probability_of_at_most(failures, trials, rate) > 1.0 - confidence;
    };
    return bisect({0.0, 1.0}, kHalvings, is_likely).fails_at;
}

} // namespace springdrive::rig

#include "engine/study/analysis/goodness_of_fit.h"

#include "base/assertions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace springdrive::study {

namespace {

/// k ln(k/expected), 0 without any.
double surprise(int count, double expected) {
    return count == 0 ? 0.0 : count * std::log(count / expected);
}

double pearson_statistic(const PsychometricFunction &function, std::span<const LevelCount> counts) {
    double sum = 0.0;
    for (const LevelCount &count : counts) {
        const double psi = possible_proportion(proportion_at(function, count.level));
        const double off = count.positive - count.trials * psi;
        sum += off * off / (count.trials * psi * (1.0 - psi));
    }
    return sum;
}

} // namespace

double deviance(const PsychometricFunction &function, std::span<const LevelCount> counts) {
    double sum = 0.0;
    for (const LevelCount &count : counts) {
        const double psi = possible_proportion(proportion_at(function, count.level));
        sum += surprise(count.positive, count.trials * psi) +
               surprise(count.trials - count.positive, count.trials * (1.0 - psi));
    }
    return 2.0 * sum;
}

GoodnessOfFit goodness_of_fit(const LikelihoodFit &fit, std::span<const LevelCount> counts,
                              const FunctionPriors &priors, RandomKey key, int simulated) {
    SPRINGDRIVE_ASSERT(simulated >= 1);
    GoodnessOfFit goodness;
    goodness.deviance = deviance(fit.function, counts);
    goodness.degrees_of_freedom =
        std::max(0, static_cast<int>(counts.size()) - fit.free_parameters);
    if (goodness.degrees_of_freedom > 0) {
        goodness.dispersion = pearson_statistic(fit.function, counts) / goodness.degrees_of_freedom;
    }
    int as_large = 1;
    for (int i = 0; i < simulated; ++i) {
        const std::vector<LevelCount> others =
            simulated_counts(fit.function, counts, child(key, static_cast<std::uint64_t>(i)));
        const double reached = deviance(maximum_likelihood(others, priors).function, others);
        as_large += reached >= goodness.deviance ? 1 : 0;
    }
    goodness.p_value = as_large / (simulated + 1.0);
    return goodness;
}

} // namespace springdrive::study

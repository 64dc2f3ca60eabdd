#include "engine/study/analysis/level_counts.h"

#include <cstdint>
#include <map>

namespace springdrive::study {

std::vector<LevelCount> counted(std::span<const PastMethodTrial> trials) {
    std::map<double, LevelCount> by_level;
    for (const PastMethodTrial &trial : trials) {
        if (!trial.outcome.marked) {
            LevelCount &count = by_level[trial.presented.level];
            count.level = trial.presented.level;
            count.positive += trial.outcome.positive ? 1 : 0;
            ++count.trials;
        }
    }
    std::vector<LevelCount> counts;
    for (const auto &[level, count] : by_level) {
        counts.push_back(count);
    }
    return counts;
}

double log_likelihood(const PsychometricFunction &function, std::span<const LevelCount> counts) {
    double sum = 0.0;
    for (const LevelCount &count : counts) {
        sum += likelihood_term(count, proportion_at(function, count.level));
    }
    return sum;
}

std::vector<LevelCount> simulated_counts(const PsychometricFunction &function,
                                         std::span<const LevelCount> design, RandomKey key) {
    std::vector<LevelCount> counts(design.begin(), design.end());
    std::uint64_t number = 0;
    for (LevelCount &count : counts) {
        const double proportion = proportion_at(function, count.level);
        count.positive = 0;
        for (int i = 0; i < count.trials; ++i) {
            count.positive += uniform(child(key, number++)) < proportion ? 1 : 0;
        }
    }
    return counts;
}

} // namespace springdrive::study

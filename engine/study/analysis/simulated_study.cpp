#include "engine/study/analysis/simulated_study.h"

#include <cstdint>

namespace springdrive::study {

Outcome answer_of(const PsychometricFunction &observer, double level, RandomKey key) {
    const Scale scale = observer.family.scale;
    const double z = standard_normal(child(key, 1));
    return {uniform(child(key, 0)) < proportion_at(observer, level),
            level_from(scale, on_scale(scale, observer.threshold) + z / observer.slope), false};
}

std::vector<PastMethodTrial> simulated_trials(const Method &method,
                                              const PsychometricFunction &observer, RandomKey key) {
    MethodRun run(method, child(key, 0));
    std::vector<PastMethodTrial> trials;
    while (const std::optional<MethodTrial> trial = run.next()) {
        const RandomKey of_answer = child(child(key, 1), static_cast<std::uint64_t>(trials.size()));
        trials.push_back({*trial, answer_of(observer, trial->level, of_answer)});
        run.add(trials.back());
    }
    return trials;
}

} // namespace springdrive::study

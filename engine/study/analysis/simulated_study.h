// A series of trials answered by an observer whose psychometric function is known.
#pragma once

#include "engine/study/methods/method.h"
#include "engine/study/methods/psychometric_function.h"
#include "engine/study/methods/random_key.h"

#include <vector>

namespace springdrive::study {

/// The observer's answer to a level: positive with probability ψ. In an adjustment the setting is
/// normal on the scale of the function, with mean u(α) and deviation 1/β.
[[nodiscard]] Outcome answer_of(const PsychometricFunction &observer, double level, RandomKey key);

/// All trials of the method.
/// @pre validate(method, task) is empty
[[nodiscard]] std::vector<PastMethodTrial>
simulated_trials(const Method &method, const PsychometricFunction &observer, RandomKey key);

} // namespace springdrive::study

// Studies of simulated observers, and what precision they promise.
#pragma once

#include "engine/study/methods/method.h"
#include "engine/study/methods/psychometric_function.h"
#include "engine/study/methods/random_key.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace springdrive::study {

// A series of trials answered by an observer whose psychometric function is known.

/// The observer's answer to a level: positive with probability ψ. In an adjustment the setting is
/// normal on the scale of the function, with mean u(α) and deviation 1/β.
[[nodiscard]] Outcome answer_of(const PsychometricFunction &observer, double level, RandomKey key);

/// All trials of the method.
/// @pre validate(method, task) is empty
[[nodiscard]] std::vector<PastMethodTrial>
simulated_trials(const Method &method, const PsychometricFunction &observer, RandomKey key);

// How many trials does a precision take? Studies with simulated observers, analysed as real ones.

struct PrecisionQuestion {
    Method method;
    FunctionPriors analysis;  ///< with which the posterior is computed; not for an adjustment
    FunctionPriors observers; ///< each simulated observer is drawn from these: known values of all
                              ///< four parameters make them alike
    std::vector<int> trials;  ///< of a study, rising: which numbers are tried
    int studies = 200;        ///< simulated for each number
    std::uint64_t seed = 1;
};

/// Empty if the question can be answered; else the first bad key, with value and range.
[[nodiscard]] std::string validate(const PrecisionQuestion &question, const Task &task);

/// What one number of trials gives. Widths and errors are on the scale of the function, so on a
/// logarithmic scale they are logarithms of ratios.
struct Precision {
    int trials = 0;
    double median_width = 0.0;  ///< of the 95 % interval of the threshold
    double width_of_most = 0.0; ///< which four of five studies do not exceed
    double bias = 0.0;          ///< mean of median − truth
    double rms_error = 0.0;     ///< of the median
    double coverage = 0.0;      ///< share of the intervals that hold the truth
};

/// The method with that number of trials, at the least: constant stimuli round up to whole blocks,
/// staircases divide them among their tracks; other stopping rules are switched off.
[[nodiscard]] Method with_trials(const Method &method, int trials);

/// One row for each number of trials. Runs on all processors.
/// @pre validate(question, task) is empty
/// @throw Cancelled if the calling thread's work was cancelled
[[nodiscard]] std::vector<Precision> precision_by_trials(const PrecisionQuestion &question);

/// The trials with which four of five studies reach the width, interpolated over ln trials; nothing
/// if none of the rows does.
[[nodiscard]] std::optional<double> trials_for_width(std::span<const Precision> rows, double width);

} // namespace springdrive::study

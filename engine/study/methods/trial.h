// A trial as a method sees it: what it asked for, and what came of it.
#pragma once

namespace springdrive::study {

/// What is to be presented.
struct MethodTrial {
    double level = 0.0; ///< of an adjustment: where it starts
    int track = 0;      ///< of staircases, else 0

    friend bool operator==(const MethodTrial &, const MethodTrial &) = default;
};

/// What came of a trial.
struct Outcome {
    bool positive = false; ///< correct, or "yes"
    double setting = 0.0;  ///< of an adjustment
    /// The trial did not happen: it tells the method nothing, and is presented again. Constant
    /// stimuli put its level back at a drawn place among those that are left in its block, not the
    /// next one if others are left; an adaptive method asks for the same level when the track has
    /// its next turn; an adjustment starts from the same level again.
    bool marked = false;

    friend bool operator==(const Outcome &, const Outcome &) = default;
};

/// A trial that was run.
struct PastMethodTrial {
    MethodTrial presented;
    Outcome outcome;

    friend bool operator==(const PastMethodTrial &, const PastMethodTrial &) = default;
};

} // namespace springdrive::study

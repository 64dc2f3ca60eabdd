// A method presents levels, one trial after the other, and decides when it is done. What it
// presents next is a function of its specification, a random key and its trials so far.
#pragma once

#include "engine/study/methods/adjustment.h"
#include "engine/study/methods/constant_stimuli.h"
#include "engine/study/methods/quest_plus.h"
#include "engine/study/methods/random_key.h"
#include "engine/study/methods/staircases.h"
#include "engine/study/methods/task.h"

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

namespace springdrive::study {

using Method = std::variant<ConstantStimuli, Staircases, QuestPlus, Adjustment>;

/// By the index of the method in the variant, as in protocol files.
inline constexpr std::array<std::string_view, 4> kMethodNames{"constant_stimuli", "staircases",
                                                              "quest_plus", "adjustment"};

/// Empty if the method can be used for the task; else the first bad key, with value and range.
[[nodiscard]] std::string what_is_wrong_with(const Method &method, const Task &task);

/// An upper bound of its trials, not counting marked ones.
[[nodiscard]] int most_trials(const Method &method);

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
    /// stimuli put its level back at a drawn place among those that are left in its block; an
    /// adaptive method asks for the same level when the track has its next turn; an adjustment
    /// starts from the same level again.
    bool marked = false;

    friend bool operator==(const Outcome &, const Outcome &) = default;
};

/// A trial that was run.
struct PastMethodTrial {
    MethodTrial presented;
    Outcome outcome;
};

/// The trial after `past`; nothing when the method is done.
/// @pre what_is_wrong_with(method, task) is empty; `past` is what this function asked for
[[nodiscard]] std::optional<MethodTrial> next_trial(const Method &method, RandomKey key,
                                                    std::span<const PastMethodTrial> past);

/// The same, trial by trial: as fast as the method allows, where `next_trial` replays.
class MethodRun {
public:
    /// @pre what_is_wrong_with(method, task) is empty
    MethodRun(const Method &method, RandomKey key);
    ~MethodRun();
    MethodRun(MethodRun &&) noexcept;
    MethodRun &operator=(MethodRun &&) noexcept;

    /// The same however often it is asked.
    [[nodiscard]] std::optional<MethodTrial> next() const;

    /// @pre `next()` is a trial: this one's outcome
    void add(const Outcome &outcome);

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace springdrive::study

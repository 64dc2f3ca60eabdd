// A method presents levels, one trial after the other, and decides when it is done. What it
// presents next is a function of its specification, a random key and its trials so far.
#pragma once

#include "engine/study/methods/adjustment.h"
#include "engine/study/methods/constant_stimuli.h"
#include "engine/study/methods/quest_plus.h"
#include "engine/study/methods/random_key.h"
#include "engine/study/methods/staircases.h"
#include "engine/study/methods/task.h"
#include "engine/study/methods/trial.h"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace springdrive::study {

using Method = std::variant<ConstantStimuli, Staircases, QuestPlus, Adjustment>;

/// By the index of the method in the variant, as in protocol files.
inline constexpr std::array<std::string_view, 4> kMethodNames{"constant_stimuli", "staircases",
                                                              "quest_plus", "adjustment"};

/// Empty if the method can be used for the task; else the first bad key, with value and range.
[[nodiscard]] std::string validate(const Method &method, const Task &task);

/// An upper bound of its trials, not counting marked ones.
[[nodiscard]] int max_trials(const Method &method);

/// A method while it runs, trial by trial.
class MethodRun {
public:
    /// @pre validate(method, task) is empty
    MethodRun(const Method &method, RandomKey key);

    [[nodiscard]] bool is_done() const;

    /// The same however often it is asked; nothing when the method is done.
    [[nodiscard]] std::optional<MethodTrial> next() const;

    /// @pre not done; `trial.presented` is `next()`
    void add(const PastMethodTrial &trial);

    /// The run itself, for what only one method knows; null for another method.
    [[nodiscard]] const StaircasesRun *staircases() const {
        return std::get_if<StaircasesRun>(&run_);
    }
    [[nodiscard]] const QuestPlusRun *quest_plus() const {
        return std::get_if<QuestPlusRun>(&run_);
    }

private:
    std::variant<ConstantStimuliRun, StaircasesRun, QuestPlusRun, AdjustmentRun> run_;
};

} // namespace springdrive::study

#include "engine/study/methods/method.h"

#include <fmt/core.h>

namespace springdrive::study {

namespace {

using AnyRun = std::variant<ConstantStimuliRun, StaircasesRun, QuestPlusRun, AdjustmentRun>;

AnyRun started(const ConstantStimuli &method, RandomKey key) {
    return ConstantStimuliRun(method, key);
}
AnyRun started(const Staircases &method, RandomKey key) { return StaircasesRun(method, key); }
AnyRun started(const QuestPlus &method, RandomKey) { return QuestPlusRun(method); }
AnyRun started(const Adjustment &method, RandomKey key) { return AdjustmentRun(method, key); }

/// What a method that is well in itself asks of its task.
std::string validate_task(const Staircases &method, const Task &task) {
    const double target = convergence_proportion(method);
    const double chance = guess_range(task).minimum;
    return target > chance
               ? std::string()
               : fmt::format("correct_for_down is {} and up_to_down {:g}, which converges to {:g} "
                             "correct; it must be above {:g}, which is chance",
                             method.correct_for_down, method.up_to_down, target, chance);
}

std::string validate_task(const QuestPlus &method, const Task &task) {
    const GuessRange range = guess_range(task);
    const Prior &guess = method.guess.prior;
    return guess.minimum >= range.minimum && guess.maximum <= range.maximum
               ? std::string()
               : fmt::format(
                     "guess is from {:g} to {:g}; in this task it must be from {:g} to {:g}",
                     guess.minimum, guess.maximum, range.minimum, range.maximum);
}

std::string validate_task(const ConstantStimuli &, const Task &) { return {}; }
std::string validate_task(const Adjustment &, const Task &) { return {}; }

} // namespace

std::string validate(const Method &method, const Task &task) {
    if (std::holds_alternative<Adjustment>(method) != (task.kind == TaskKind::adjustment)) {
        return fmt::format("method is {} and the task is {}; adjustment is both or neither",
                           kMethodNames[method.index()],
                           kTaskKindNames[static_cast<std::size_t>(task.kind)]);
    }
    return std::visit(
        [&](const auto &one) {
            const std::string error = validate(one);
            return error.empty() ? validate_task(one, task) : error;
        },
        method);
}

int max_trials(const Method &method) {
    return std::visit([](const auto &one) { return max_trials(one); }, method);
}

MethodRun::MethodRun(const Method &method, RandomKey key)
    : run_(std::visit([key](const auto &one) { return started(one, key); }, method)) {}

bool MethodRun::is_done() const {
    return std::visit([](const auto &run) { return run.is_done(); }, run_);
}

std::optional<MethodTrial> MethodRun::next() const {
    return std::visit([](const auto &run) { return run.next(); }, run_);
}

void MethodRun::add(const PastMethodTrial &trial) {
    std::visit([&](auto &run) { run.add(trial); }, run_);
}

} // namespace springdrive::study

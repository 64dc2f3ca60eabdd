// The tables of the procedure: what a participant does in a trial, and which trial comes next.
#include "engine/study/protocol/toml_tables.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

namespace springdrive::study {

namespace {

constexpr std::size_t kMostSteps = 100;

void read_axis(StrictTomlTable &method, std::string_view key, PriorAxis &axis) {
    if (!method.has_optional(key)) {
        return;
    }
    StrictTomlTable table = method.table(key);
    read_choice(table, "scale", kScaleNames, axis.prior.scale);
    read_choice(table, "density", kDensityNames, axis.prior.density);
    read_numbers(table, kPriorKeys, axis.prior);
    read_numbers(table, kPriorAxisKeys, axis);
    table.refuse_unknown_keys();
}

ConstantStimuli read_constant_stimuli(StrictTomlTable &table) {
    ConstantStimuli method;
    method.levels = table.numbers("levels", {-kLargestLevel, kLargestLevel}, 1000);
    read_numbers(table, kConstantStimuliKeys, method);
    return method;
}

Staircases read_staircases(StrictTomlTable &table) {
    Staircases method;
    read_choice(table, "scale", kScaleNames, method.scale);
    method.start_levels = table.numbers("start_levels", {-kLargestLevel, kLargestLevel}, 100);
    read_numbers(table, kStaircaseKeys, method);
    table.rows("steps", kMostSteps, [&method](StrictTomlTable &row) {
        StepSize step;
        read_numbers(row, kStepKeys, step);
        row.refuse_unknown_keys();
        method.steps.push_back(step);
    });
    return method;
}

QuestPlus read_quest_plus(StrictTomlTable &table, const Task &task) {
    QuestPlus method;
    read_choice(table, "shape", kShapeNames, method.family.shape);
    read_choice(table, "scale", kScaleNames, method.family.scale);
    method.levels = table.numbers("levels", {-kLargestLevel, kLargestLevel}, 1000);
    const GuessRange guess = guess_range(task);
    method.threshold.prior.scale = method.family.scale;
    method.slope.prior.scale = Scale::logarithmic;
    method.guess.prior.minimum = guess.minimum;
    method.guess.prior.maximum = guess.maximum;
    method.guess.points = guess.minimum == guess.maximum ? 1 : 5;
    method.lapse.prior = known(0.02);
    for (const auto &[key, axis] :
         {std::pair{"threshold", &method.threshold}, std::pair{"slope", &method.slope}}) {
        if (!table.has(key)) {
            table.refuse(key, "is missing; add a table [method." + std::string(key) +
                                  "] with minimum, maximum and points");
        }
        read_axis(table, key, *axis);
    }
    read_axis(table, "guess", method.guess);
    read_axis(table, "lapse", method.lapse);
    read_numbers(table, kQuestPlusKeys, method);
    return method;
}

Adjustment read_adjustment(StrictTomlTable &table) {
    Adjustment method;
    read_choice(table, "scale", kScaleNames, method.scale);
    read_numbers(table, kAdjustmentKeys, method);
    return method;
}

Method read_method(StrictTomlTable &table, const Task &task) {
    switch (table.choice("kind", kMethodNames)) {
    case 0:
        return read_constant_stimuli(table);
    case 1:
        return read_staircases(table);
    case 2:
        return read_quest_plus(table, task);
    default:
        return read_adjustment(table);
    }
}

} // namespace

void read_procedure(StrictTomlTable &file, Protocol &protocol) {
    StrictTomlTable task = file.table("task");
    protocol.task.kind = static_cast<TaskKind>(task.choice("kind", kTaskKindNames));
    read_numbers(task, kTaskKeys, protocol.task);
    task.refuse_unknown_keys();
    refuse_as(task, what_is_wrong_with(protocol.task));

    StrictTomlTable method = file.table("method");
    protocol.method = read_method(method, protocol.task);
    method.refuse_unknown_keys();
    refuse_as(method, what_is_wrong_with(protocol.method, protocol.task));

    if (file.has_optional("practice")) {
        StrictTomlTable practice = file.table("practice");
        read_levels(practice, "levels", protocol.practice.levels);
        read_numbers(practice, kPracticeKeys, protocol.practice);
        practice.refuse_unknown_keys();
    }
    if (file.has_optional("catch_trials")) {
        StrictTomlTable catch_trials = file.table("catch_trials");
        read_levels(catch_trials, "levels", protocol.catch_trials.levels);
        read_numbers(catch_trials, kCatchTrialKeys, protocol.catch_trials);
        catch_trials.refuse_unknown_keys();
    }
}

} // namespace springdrive::study

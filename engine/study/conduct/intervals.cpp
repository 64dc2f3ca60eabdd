#include "engine/study/conduct/intervals.h"

#include <optional>
#include <utility>

namespace springdrive::study {

namespace {

Presented presented_of(const Protocol &protocol, std::size_t condition, std::optional<double> level,
                       Condition parameters) {
    control::Tuning free_space =
        free_space_tuning(protocol, parameters).value_or(parameters.tuning);
    return {condition, level, std::move(parameters), free_space};
}

} // namespace

Interval comparison_at(const Protocol &protocol, const PlannedTrial &planned, double level) {
    const int target = planned.presented.target;
    const bool by_place = protocol.task.kind == TaskKind::forced_choice_by_place;
    return {presented_of(protocol, planned.condition, level,
                         comparison(protocol, planned.condition, level, target)),
            true, by_place ? target : 0};
}

std::vector<Interval> intervals_of(const Protocol &protocol, const PlannedTrial &planned) {
    const Interval standard_one{
        presented_of(protocol, standard_condition_of(protocol).value_or(planned.condition),
                     std::nullopt, standard(protocol, planned.condition)),
        false, 0};
    const int count = presentations_per_trial(protocol);
    const bool by_interval = protocol.task.kind == TaskKind::forced_choice_by_interval;
    const int at = by_interval ? planned.presented.target : count - 1;
    std::vector<Interval> intervals(static_cast<std::size_t>(count), standard_one);
    intervals[static_cast<std::size_t>(at)] =
        comparison_at(protocol, planned, planned.presented.level);
    return intervals;
}

} // namespace springdrive::study

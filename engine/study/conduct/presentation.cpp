#include "engine/study/conduct/presentation.h"

#include "engine/study/conduct/marking.h"

#include <algorithm>
#include <string>
#include <utility>

namespace springdrive::study {

static_assert(std::ranges::all_of(kStimulusMeasures, [](const StimulusMeasure &measure) {
    return std::ranges::count(kMeasuredValues, measure.name, &MeasuredValue::name) == 1;
}));

std::size_t condition_of(const Protocol &protocol, const PlannedTrial &planned) {
    const auto found = std::ranges::find(protocol.conditions, planned.condition, &Condition::name);
    return static_cast<std::size_t>(found - protocol.conditions.begin());
}

namespace {

Presented presented_of(const Protocol &protocol, std::size_t condition, std::optional<double> level,
                       Condition parameters, int target) {
    control::Tuning free_space =
        free_space_tuning(protocol, parameters).value_or(parameters.tuning);
    return {condition, level, std::move(parameters), free_space, target};
}

} // namespace

Presented comparison_at(const Protocol &protocol, const PlannedTrial &planned, double level) {
    const std::size_t condition = condition_of(protocol, planned);
    const bool by_place = protocol.task.kind == TaskKind::forced_choice_by_place;
    const int target = by_place ? planned.target.value() - 1 : 0;
    return presented_of(protocol, condition, level, comparison(protocol, condition, level, target),
                        target);
}

std::vector<Presented> intervals_of(const Protocol &protocol, const PlannedTrial &planned) {
    const std::size_t condition = condition_of(protocol, planned);
    const int count = presentations_per_trial(protocol);
    const bool by_interval = protocol.task.kind == TaskKind::forced_choice_by_interval;
    const int at = by_interval ? planned.target.value() : count;
    std::vector<Presented> intervals(
        static_cast<std::size_t>(count),
        presented_of(protocol, standard_condition_of(protocol).value_or(condition), std::nullopt,
                     standard(protocol, condition), 0));
    intervals[static_cast<std::size_t>(at - 1)] =
        comparison_at(protocol, planned, planned.level.value());
    return intervals;
}

Presentation presentation_of(const StimulusMeasures &intended, const DeliveredStimulus &delivered) {
    Presentation presentation;
    presentation.start_s = delivered.start_s;
    presentation.end_s = delivered.end_s;
    for (const StimulusMeasure &measure : kStimulusMeasures) {
        const std::optional<double> wanted = intended.*measure.value;
        const std::optional<double> came = delivered.measures.*measure.value;
        if (wanted || came) {
            presentation.values.push_back({std::string(measure.name), wanted, came});
        }
    }
    presentation.values.push_back({"lateness_s", 0.0, delivered.lateness_s});
    presentation.values.push_back({"peak_force_N", std::nullopt, delivered.peak_force_N});
    presentation.values.push_back({"aside_m", std::nullopt, delivered.aside_m});
    return presentation;
}

std::vector<Setting> settings_of(const Condition &condition) {
    std::vector<Setting> settings;
    settings.reserve(control::kParameters.size() + 4);
    for (const control::Parameter &gain : control::kParameters) {
        settings.push_back({std::string(gain.name), condition.tuning.*gain.value});
    }
    settings.push_back({"map", std::string(control::name_of(condition.tuning.map))});
    settings.push_back({"alpha_mode", std::string(control::name_of(condition.tuning.alpha_mode))});
    settings.push_back({"servo_hz", condition.servo_hz});
    settings.push_back({"delay_periods", condition.delay_periods});
    return settings;
}

} // namespace springdrive::study

#include "engine/study/conduct/presentation.h"

#include "engine/study/conduct/marking.h"

#include <algorithm>
#include <string>

namespace springdrive::study {

static_assert(std::ranges::all_of(kStimulusMeasures, [](const StimulusMeasure &measure) {
    return std::ranges::count(kMeasuredValues, measure.name, &MeasuredValue::name) == 1;
}));

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

#include "engine/study/protocol/presented_stimulus.h"

#include "engine/study/protocol/predicted_press.h"

#include <algorithm>
#include <optional>

namespace springdrive::study {

namespace {

void set_direction(StimulusMeasures &measures, const TurnFrame &frame, const Vector3 &force) {
    const ForceAngles angles = force_angles(frame, force);
    measures.turn_deg = angles.turn_deg;
    measures.across_deg = angles.across_deg;
}

} // namespace

bool is_steered(const Protocol &protocol, const Condition &condition) {
    switch (protocol.stimulus) {
    case StimulusForm::press:
        return condition.turn_deg != 0.0 || (condition.hold == Hold::cup &&
                                             condition.tuning.map == control::MotionMap::transpose);
    case StimulusForm::blow:
        return condition.turn_deg != 0.0;
    case StimulusForm::pulse:
    case StimulusForm::stroke:
        break;
    }
    return false;
}

double longest_glide_back_s(const Protocol &protocol) {
    double longest_s = 0.0;
    for (const Presented &presented : all_presented(protocol)) {
        Stimulus stimulus;
        stimulus.form = protocol.stimulus;
        stimulus.contact = presented.parameters.tuning;
        stimulus.free_space = presented.free_space;
        stimulus.is_steered = is_steered(protocol, presented.parameters);
        longest_s = std::max(longest_s, glide_back_s(stimulus));
    }
    return longest_s;
}

Stimulus stimulus_of(const Protocol &protocol, const StudySetting &setting,
                     const Presented &presented) {
    const Condition &condition = presented.parameters;
    const scene::TouchSpot &spot = setting.conditions[presented.condition].spot;
    Stimulus stimulus;
    stimulus.form = protocol.stimulus;
    stimulus.hold = condition.hold;
    stimulus.contact = condition.tuning;
    stimulus.free_space = presented.free_space;
    stimulus.start_m = protocol.stimulus == StimulusForm::stroke
                           ? spot.point_m
                           : Vector3(spot.point_m + kApproach_m * spot.normal);
    stimulus.frame = {spot.normal, turn_axis(spot.normal, condition.turn_axis_deg)};
    stimulus.direction = turned(condition, spot.normal);
    stimulus.is_steered = is_steered(protocol, condition);
    stimulus.pulse = {condition.pulse_N, condition.pulse_hz};
    stimulus.rest_s = protocol.timing.rest_s;
    stimulus.approach_s = protocol.timing.approach_s;
    stimulus.presentation_s = protocol.timing.presentation_s;
    stimulus.min_glide_back_s = longest_glide_back_s(protocol);
    return stimulus;
}

StimulusMeasures intended_measures(const Protocol &protocol, const StudySetting &setting,
                                   const Presented &presented) {
    const Stimulus stimulus = stimulus_of(protocol, setting, presented);
    const Condition &condition = presented.parameters;
    StimulusMeasures measures;
    if (stimulus.form == StimulusForm::stroke || stimulus.form == StimulusForm::blow) {
        measures.speed_m_per_s = condition.speed_m_per_s;
        if (stimulus.is_steered) {
            set_direction(measures, stimulus.frame, stimulus.direction);
        }
        return measures;
    }
    const std::optional<PredictedPress> press = predicted_press(setting, presented, stimulus.form);
    if (!press) {
        return measures;
    }
    measures.stiffness_N_per_m = press->stiffness_N_per_m;
    measures.press_N = condition.press_N;
    if (stimulus.form == StimulusForm::pulse) {
        measures.pulse_N = condition.pulse_N;
        set_direction(measures, stimulus.frame, stimulus.direction);
    } else if (stimulus.is_steered || stimulus.hold == Hold::surface) {
        set_direction(measures, stimulus.frame, press->held_N);
    }
    return measures;
}

} // namespace springdrive::study

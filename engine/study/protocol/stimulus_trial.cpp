#include "engine/study/protocol/stimulus_trial.h"

#include "engine/lab/rig/servo_rig.h"
#include "engine/study/protocol/presented_stimulus.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::study {

namespace {

constexpr double kLast_s = 0.1; ///< of a press, in which the hand should be still

/// What tells all of it.
double long_enough_s(const Stimulus &stimulus, const Condition &condition) {
    switch (stimulus.form) {
    case StimulusForm::press:
        return 1.0;
    case StimulusForm::blow:
        return 0.3;
    case StimulusForm::pulse:
        return 0.5 + std::max(0.5, stimulus.pulse.length_s() + kAfterPulse_s);
    case StimulusForm::stroke:
        break;
    }
    return std::max(1.0, std::numbers::pi * kStroke_m / condition.speed_m_per_s);
}

Stimulus cut(Stimulus stimulus, const Condition &condition) {
    stimulus.presentation_s = std::min(stimulus.presentation_s, long_enough_s(stimulus, condition));
    return stimulus;
}

} // namespace

StimulusTrial try_stimulus(const Protocol &protocol, const StudySetting &setting,
                           const Presented &presented, const StimulusCircumstances &circumstances) {
    const Condition &condition = presented.parameters;
    StimulusTrial seen;
    seen.name = name_of(protocol, presented);
    seen.stimulus = cut(stimulus_of(protocol, setting, presented), condition);
    HandCourse course = hand_course(setting, presented, seen.stimulus, circumstances.hand);
    if (circumstances.strokes_after_s > 0.0) {
        const simulated::HandPath::Point last = course.points.back();
        const std::vector<simulated::HandPath::Point> strokes =
            stroke_points(last.position_m, last.time_s + 0.5, circumstances.strokes_after_s,
                          condition.speed_m_per_s);
        course.points.insert(course.points.end(), strokes.begin(), strokes.end());
    }

    simulated::SimulationOptions options;
    options.servo_period_s = 1.0 / condition.servo_hz;
    options.delay_periods = condition.delay_periods;
    options.path.emplace(course.points);
    options.ambient_C = circumstances.winding_C.value_or(protocol.windings.from_C);
    options.device_seed = circumstances.device_seed;
    rig::ServoRig rig(setting.device, options, course.points.front().position_m,
                      setting.conditions[presented.condition].surface.get());
    rig.inputs.tuning = presented.free_space;
    rig.inputs.global_alpha_rad2_per_m2 = setting.global_alpha_rad2_per_m2;
    rig.inputs.observes_resistance = true;

    StimulusRun run(setting.device, seen.stimulus, options.servo_period_s);
    DeliveryMeter meter(setting.device, seen.stimulus, options.servo_period_s);
    const auto ticks = std::lround(course.points.back().time_s * condition.servo_hz);
    for (long tick = 0; tick < ticks && run.phase() != StimulusPhase::failed; ++tick) {
        const servo::ServoSample &sample = rig.tick();
        run.update(sample, rig.inputs);
        meter.take(sample, run);
        seen.has_touched = seen.has_touched || sample.contact.touching;
        const double left_s = seen.stimulus.presentation_s - run.presented_s();
        if (course.is_held && run.phase() == StimulusPhase::presenting && left_s < kLast_s) {
            seen.shaking_m_per_s =
                std::max(seen.shaking_m_per_s, rig.truth().tip_velocity_m_per_s.norm());
        }
        if (circumstances.watch) {
            circumstances.watch(sample, run.phase());
        }
    }
    // Windings and housings were as warm as the air.
    seen.duration_s = rig.last.time_s;
    seen.winding_rise_K = rig.truth().winding_C - Vector3::Constant(options.ambient_C);
    seen.housing_rise_K = rig.truth().housing_C - Vector3::Constant(options.ambient_C);
    seen.delivered = meter.delivered();
    seen.failure = run.failure();
    if (rig.has_tripped()) {
        seen.trip = servo::description(rig.last.safety);
    }
    return seen;
}

} // namespace springdrive::study

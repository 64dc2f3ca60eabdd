#include "engine/study/stimuli/stimulus.h"

#include "base/degrees.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::study {

ForceAngles force_angles(const TurnFrame &frame, const Vector3 &force) {
    const Vector3 towards = frame.turn_axis.cross(frame.normal);
    const double along = force.dot(frame.normal);
    const double turned = force.dot(towards);
    return {kDegreesPerRadian * std::atan2(turned, along),
            kDegreesPerRadian * std::atan2(force.dot(frame.turn_axis), std::hypot(turned, along))};
}

double Pulse::force_N(double since_s) const noexcept {
    const double phase = since_s * frequency_hz;
    return phase < 0.0 || phase > 1.0
               ? 0.0
               : 0.5 * height_N * (1.0 - std::cos(2.0 * std::numbers::pi * phase));
}

double Pulse::rate_N_per_s(double since_s) const noexcept {
    const double phase = since_s * frequency_hz;
    return phase < 0.0 || phase > 1.0 ? 0.0
                                      : std::numbers::pi * frequency_hz * height_N *
                                            std::sin(2.0 * std::numbers::pi * phase);
}

double Stimulus::pulse_from_s() const {
    return std::max(
        0.0, std::min(0.5 * presentation_s, presentation_s - pulse.length_s() - kAfterPulse_s));
}

double glide_back_s(const Stimulus &stimulus) {
    constexpr double kTunings_s = 0.5;
    constexpr double kSteering_s = 0.25;
    const bool glides = stimulus.contact.dR_Ohm != stimulus.free_space.dR_Ohm ||
                        stimulus.contact.lambda_rad_per_s != stimulus.free_space.lambda_rad_per_s;
    if (stimulus.form == StimulusForm::stroke) {
        return 0.0;
    }
    return std::max(stimulus.min_glide_back_s, glides                ? kTunings_s
                                               : stimulus.is_steered ? kSteering_s
                                                                     : 0.0);
}

} // namespace springdrive::study

// How a simulated hand moves when it is presented a stimulus.
#pragma once

#include "device/simulated/hand_path.h"
#include "engine/study/protocol/presented.h"
#include "engine/study/stimuli/stimulus.h"

#include <optional>
#include <vector>

namespace springdrive::study {

/// In what a hand differs from what a protocol asks of it.
struct HandDeviation {
    double share = 1.0;               ///< of the press, or of the speed of a blow or stroke
    Vector3 aside_m{Vector3::Zero()}; ///< of where it comes down
};

/// The hand's path, and when it is where the stimulus wants it.
struct HandCourse {
    std::vector<simulated::HandPath::Point> points;
    double from_s = 0.0;
    double until_s = 0.0;
    bool is_held = false; ///< at its end the hand presses and is still
};

/// To and fro along a sine with that speed at most, which it reaches softly.
[[nodiscard]] std::vector<simulated::HandPath::Point>
stroke_points(const Vector3 &about_m, double from_s, double duration_s, double speed_m_per_s);

/// So long a course waits for a servo that has just been started: for rest, and until its gains are
/// raised.
inline constexpr double kServoStart_s = 1.25;

/// Of the relaxed grip of `device::HandParameters`: it rests at the start until the servo runs and
/// for the time that the stimulus wants, does what the form asks for, and goes back. Where it
/// presses it makes up for the weight of the linkage, so that the device pushes back as hard as the
/// condition says. It does not make up for a force along the surface, and yields to it.
[[nodiscard]] HandCourse hand_course(const StudySetting &setting, const Presented &presented,
                                     const Stimulus &stimulus, const HandDeviation &hand);

} // namespace springdrive::study

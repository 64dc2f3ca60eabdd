// A stimulus presented to a simulated hand: the whole servo in closed loop with the simulated
// device, its limiter and its safety monitor included.
#pragma once

#include "engine/servo/servo_sample.h"
#include "engine/study/protocol/hand_course.h"
#include "engine/study/stimuli/delivery_meter.h"

#include <cstdint>
#include <functional>
#include <string>

namespace springdrive::study {

/// What may be other than in the protocol, and other than with the device that its file describes.
struct StimulusCircumstances {
    HandDeviation hand;
    /// Of windings, housings and air at the beginning; nothing: `WindingBand::from_C`.
    std::optional<double> winding_C;
    std::uint64_t device_seed = 0; ///< see `simulated::SimulationOptions`
    /// After all of it the hand rests for half a second, and then strokes to and fro in free space
    /// for so long.
    double strokes_after_s = 0.0;
    /// Called with each sample of the servo and the phase after it; may be empty.
    std::function<void(const servo::ServoSample &, StimulusPhase)> watch;
};

struct StimulusTrial {
    std::string name;  ///< of what was presented, see `name_of`
    Stimulus stimulus; ///< as it was presented
    DeliveredStimulus delivered;
    StimulusFailure failure = StimulusFailure::none;
    std::string trip;             ///< of the safety monitor, with its numbers; empty: none
    double shaking_m_per_s = 0.0; ///< of the tip at the end of a press, the hand being still
    bool has_touched = false;
    // Of the windings' heat alone, until the end of it:
    double duration_s = 0.0;
    Vector3 winding_rise_K{Vector3::Zero()};
    Vector3 housing_rise_K{Vector3::Zero()};
};

/// A presentation is cut to what tells all: a second, of a blow 0.3 s, of a pulse its own time and
/// half a second before it, of a stroke a second and half a period at least.
/// Deterministic; some tenths of a second for a second of stimulus at 1 kHz.
[[nodiscard]] StimulusTrial try_stimulus(const Protocol &protocol, const StudySetting &setting,
                                         const Presented &presented,
                                         const StimulusCircumstances &circumstances = {});

} // namespace springdrive::study

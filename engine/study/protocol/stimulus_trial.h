// Stimuli and warm-ups tried on the simulated device, in a simulated hand.
#pragma once

#include "device/simulated/hand.h"
#include "engine/servo/servo_sample.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/stimuli/stimulus.h"
#include "engine/study/stimuli/warm_up.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::study {

// How a simulated hand moves when it is presented a stimulus.

/// In what a hand differs from what a protocol asks of it.
struct HandDeviation {
    double share = 1.0;               ///< of the press, or of the speed of a blow or stroke
    Vector3 aside_m{Vector3::Zero()}; ///< of where it comes down
};

/// The hand's path, and when it is where the stimulus wants it.
struct HandTrajectory {
    std::vector<simulated::HandPath::Point> points;
    double from_s = 0.0;
    double until_s = 0.0;
    bool is_held = false; ///< at its end the hand presses and is still
};

/// So long a trajectory waits for a servo that has just been started: for rest, and until its gains
/// are raised.
inline constexpr double kServoStart_s = 1.25;

/// Of the relaxed grip of `device::HandParameters`: it rests at the start until the servo runs and
/// for the time that the stimulus wants, does what the form asks for, and goes back. Where it
/// presses it makes up for the weight of the linkage, so that the device pushes back as hard as the
/// condition says. It does not make up for a force along the surface, and yields to it.
[[nodiscard]] HandTrajectory hand_trajectory(const StudySetting &setting,
                                             const Presented &presented, const Stimulus &stimulus,
                                             const HandDeviation &hand);

// A stimulus presented to a simulated hand: the whole servo in closed loop with the simulated
// device, its limiter and its safety monitor included.

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

// The warm-up before a session: how long it takes by the thermal network, and simulated by the
// whole servo in closed loop with the simulated device.

/// Where the hand is meanwhile: where it rests before the stimuli of the first condition that has a
/// place within reach.
[[nodiscard]] Vector3 warming_place_m(const Protocol &protocol, const StudySetting &setting);

/// The largest currents of a warm-up there [A].
[[nodiscard]] Vector3 warming_current_A(const StudySetting &setting, const Vector3 &place_m);

/// From the air's temperature until the slowest winding is warm and the tuning is back; infinite if
/// that takes longer than `WarmUp::kMax_s` [s].
[[nodiscard]] double predicted_warm_up_s(const Protocol &protocol, const StudySetting &setting);

/// Of the three motors' windings and housings, in air of the protocol's `air_C`.
struct MotorTemperatures {
    Vector3 winding_C{Vector3::Zero()};
    Vector3 housing_C{Vector3::Zero()};
};

/// After so much time without a current, by the two-body network of winding_heat.h.
[[nodiscard]] MotorTemperatures cooled(const device::DeviceDescription &device, double air_C,
                                       const MotorTemperatures &before, double seconds);

struct WarmUpTrial {
    MotorTemperatures after; ///< true ones
    double duration_s = 0.0;
    double hand_force_N = 0.0; ///< largest deviation from that of a hand that holds still
    WarmUpFailure failure = WarmUpFailure::none;
    std::string trip; ///< of the safety monitor, with its numbers; empty: none
};

/// With the relaxed grip of a hand that holds still, at 1 kHz or the first condition's rate.
/// Deterministic; some hundredths of a second for a second.
///
/// A simulated device begins with all windings and housings as warm as the air, which is here the
/// coldest winding. What they were beyond that at the beginning cools by the network; as it is
/// linear, the sum is what a servo would have seen that had watched them all the time.
[[nodiscard]] WarmUpTrial try_warm_up(const Protocol &protocol, const StudySetting &setting,
                                      const MotorTemperatures &before);

} // namespace springdrive::study

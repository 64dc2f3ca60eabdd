// A test signal of the simulated hand: its target moves along a line, beside where it is held.
#pragma once

#include "base/vector.h"
#include "device/simulated/hand_path.h"

#include <array>
#include <cstdint>

namespace springdrive::simulated {

enum class StimulusKind : std::uint8_t {
    none,
    step,  ///< out within 5 ms, and back within 5 ms after half of the time
    hold,  ///< out within a fifth of the time, and back within the last fifth
    chirp, ///< a sine whose frequency rises exponentially, fading in and out over a tenth each
};

inline constexpr std::array<const char *, 4> kStimulusLabels{"none", "step", "press and hold",
                                                             "chirp"};

struct HandStimulus {
    StimulusKind kind = StimulusKind::none;
    Vector3 direction{Vector3::UnitY()}; ///< unit vector
    double amplitude_m = 0.0;
    double duration_s = 1.0;
    double from_Hz = 1.0; ///< of a chirp
    double to_Hz = 20.0;
    std::uint32_t number = 0; ///< a change starts the signal
};

/// Beside the hand's own target, at a time since the start; zero before it and after its end.
/// RT-safe.
[[nodiscard]] HandTarget offset_of(const HandStimulus &stimulus, double time_s) noexcept;

} // namespace springdrive::simulated

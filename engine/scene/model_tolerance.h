// How far from the fullest model a scene may be felt to be.
#pragma once

namespace springdrive::scene {

/// What a cheaper model of a scene may be off. The defaults are what hands hardly tell: about the
/// device's own friction (0.04 N at the tip), a fifth of the 25° at which the paper has directions
/// noticed, and the frequencies of touch up to where texture begins.
struct ModelTolerance {
    double force_N = 0.05;         ///< rms of the force on the hand
    double direction_rad = 0.0873; ///< rms of its direction while touching; 5°
    double bandwidth_hz = 200.0;   ///< both below this frequency
};

} // namespace springdrive::scene

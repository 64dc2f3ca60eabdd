#include "device/simulated/hand_stimulus.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::simulated {

namespace {

constexpr double kStepRise_s = 0.005;

/// A value with its rate.
struct Moving {
    double value = 0.0;
    double rate_per_s = 0.0;
};

/// From 0 to 1 within `rise_s`, smoothly: half a cosine.
Moving rising(double time_s, double rise_s) {
    if (time_s <= 0.0) {
        return {0.0, 0.0};
    }
    if (time_s >= rise_s) {
        return {1.0, 0.0};
    }
    const double phase = std::numbers::pi * time_s / rise_s;
    return {0.5 * (1.0 - std::cos(phase)), 0.5 * std::numbers::pi / rise_s * std::sin(phase)};
}

/// Out with `rise_s`, and back with it from `back_s` on.
Moving out_and_back(double time_s, double rise_s, double back_s) {
    const Moving out = rising(time_s, rise_s);
    const Moving back = rising(time_s - back_s, rise_s);
    return {out.value - back.value, out.rate_per_s - back.rate_per_s};
}

Moving chirp(const HandStimulus &stimulus, double time_s) {
    // φ(t) = 2π f₀ (kᵗ − 1)/ln k, so that f(t) = f₀ kᵗ; k = 1 is a sine.
    const double growth = std::log(stimulus.to_Hz / stimulus.from_Hz) / stimulus.duration_s; // ln k
    const double omega_0 = 2.0 * std::numbers::pi * stimulus.from_Hz;
    const double phase =
        std::abs(growth) < 1e-9 ? omega_0 * time_s : omega_0 * std::expm1(growth * time_s) / growth;
    const double omega = omega_0 * std::exp(growth * time_s);
    const double fade_s = 0.1 * stimulus.duration_s;
    const Moving fade = out_and_back(time_s, fade_s, stimulus.duration_s - fade_s);
    return {fade.value * std::sin(phase),
            fade.value * omega * std::cos(phase) + fade.rate_per_s * std::sin(phase)};
}

} // namespace

HandTarget offset_of(const HandStimulus &stimulus, double time_s) noexcept {
    if (time_s < 0.0 || time_s > stimulus.duration_s) {
        return {};
    }
    Moving moving;
    switch (stimulus.kind) {
    case StimulusKind::none:
        break;
    case StimulusKind::step:
        moving = out_and_back(time_s, std::min(kStepRise_s, 0.5 * stimulus.duration_s),
                              0.5 * stimulus.duration_s);
        break;
    case StimulusKind::hold:
        moving = out_and_back(time_s, 0.2 * stimulus.duration_s, 0.8 * stimulus.duration_s);
        break;
    case StimulusKind::chirp:
        moving = chirp(stimulus, time_s);
        break;
    }
    return {stimulus.amplitude_m * moving.value * stimulus.direction,
            stimulus.amplitude_m * moving.rate_per_s * stimulus.direction};
}

} // namespace springdrive::simulated

// The converter that digitises a motor's current for the servo.
#pragma once

#include "base/split_mix.h"
#include "device/simulated/drawn_device.h"

#include <cmath>
#include <cstdint>

namespace springdrive::simulated {

/// RT-safe. The noise is a sequence that depends on the seed only.
class CurrentConverter {
public:
    explicit CurrentConverter(std::uint64_t seed) : state_(seed) {}

    /// gain · i + offset + noise, rounded to the resolution [A].
    [[nodiscard]] double reading_A(const MotorSensing &sensing, double current_A) noexcept {
        double reading_A = sensing.converter.gain * current_A + sensing.converter.offset_A;
        if (sensing.noise_A > 0.0) {
            reading_A += sensing.noise_A * normal();
        }
        return sensing.resolution_A > 0.0
                   ? sensing.resolution_A * std::nearbyint(reading_A / sensing.resolution_A)
                   : reading_A;
    }

private:
    /// Uniform in [0, 1).
    [[nodiscard]] double uniform() noexcept {
        state_ += split_mix::kStep;
        return split_mix::unit_share(split_mix::scattered(state_));
    }

    /// Mean 0, variance 1, to within 6: the sum of twelve uniform values (Irwin-Hall).
    [[nodiscard]] double normal() noexcept {
        double sum = -6.0;
        for (int i = 0; i < 12; ++i) {
            sum += uniform();
        }
        return sum;
    }

    std::uint64_t state_;
};

} // namespace springdrive::simulated

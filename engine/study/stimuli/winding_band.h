// The temperatures in which a study keeps its windings, and what the servo knows of them.
#pragma once

#include "base/vector.h"
#include "engine/servo/servo_sample.h"

#include <cstddef>

namespace springdrive::study {

/// The windings are warmed to this band before the first trial and kept in it.
struct WindingBand {
    double air_C = 25.0;
    double from_C = 30.0;
    double to_C = 60.0;

    friend bool operator==(const WindingBand &, const WindingBand &) = default;
};

/// By the safety monitor, the middle of its bounds: the air is taken to be between 15 and 35 °C.
/// RT-safe.
[[nodiscard]] inline Vector3 estimated_windings_C(const servo::ServoSample &sample) noexcept {
    Vector3 winding_C;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const servo::WindingStatus &winding = sample.winding[static_cast<std::size_t>(j)];
        winding_C[j] = 0.5 * (winding.min_C + winding.max_C);
    }
    return winding_C;
}

} // namespace springdrive::study

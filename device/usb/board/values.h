// What the core exchanges with a chip in every loop, and products and definiteness of symmetric
// 3 × 3 matrices.
#pragma once

#include "device/usb/protocol.h"

namespace springdrive::board {

using usb::kChannels;
using usb::kNotMeasured;
using usb::SymmetricMatrix;
using usb::Triple;

/// Everything measured at one time.
struct Samples {
    std::uint32_t time_us = 0;                      ///< when the currents were sampled
    std::array<std::uint16_t, kChannels> encoder{}; ///< hardware counters, modulo 2^16
    Triple current_A{};            ///< by the sensors' nominal scale; NaN: no conversion
    float supply_V = kNotMeasured; ///< of the power stages
    std::array<float, usb::kTemperatures> temperature_C{kNotMeasured, kNotMeasured, kNotMeasured,
                                                        kNotMeasured};
    bool is_enabled = true;    ///< hardware enable line; true where there is none
    bool is_stopped = false;   ///< stop switch
    bool stage_failed = false; ///< a power stage's own fault output
};

/// State of one channel's power stage.
enum class Stage : std::uint8_t {
    brake, ///< both ends of the winding to the same rail
    drive, ///< PWM with a duty ratio
    open,  ///< all transistors off
};

struct BridgeOrder {
    std::array<Stage, kChannels> stage{Stage::brake, Stage::brake, Stage::brake};
    Triple duty_ratio{}; ///< of the driven stages: mean voltage by supply, from −1 to 1, finite

    [[nodiscard]] static constexpr BridgeOrder braking() { return {}; }
    [[nodiscard]] static constexpr BridgeOrder opening() {
        return {{Stage::open, Stage::open, Stage::open}, {}};
    }
};

[[nodiscard]] constexpr float magnitude(float value) { return value < 0.0F ? -value : value; }

/// a + M b; for a diagonal M, `add_diagonal_product` gives the same in a third of the time.
[[nodiscard]] constexpr Triple add_product(const Triple &a, const SymmetricMatrix &M,
                                           const Triple &b) {
    const Triple &d = M.diagonal;
    const Triple &o = M.off_diagonal;
    return {a[0] + (d[0] * b[0] + o[0] * b[1] + o[1] * b[2]),
            a[1] + (o[0] * b[0] + d[1] * b[1] + o[2] * b[2]),
            a[2] + (o[1] * b[0] + o[2] * b[1] + d[2] * b[2])};
}

[[nodiscard]] constexpr Triple add_diagonal_product(const Triple &a, const SymmetricMatrix &M,
                                                    const Triple &b) {
    return {a[0] + M.diagonal[0] * b[0], a[1] + M.diagonal[1] * b[1], a[2] + M.diagonal[2] * b[2]};
}

/// factor M + N.
[[nodiscard]] constexpr SymmetricMatrix scaled_sum(float factor, const SymmetricMatrix &M,
                                                   const SymmetricMatrix &N) {
    SymmetricMatrix sum;
    for (std::size_t i = 0; i < kChannels; ++i) {
        sum.diagonal[i] = factor * M.diagonal[i] + N.diagonal[i];
        sum.off_diagonal[i] = factor * M.off_diagonal[i] + N.off_diagonal[i];
    }
    return sum;
}

/// Sylvester's criterion. False for elements so large that a product overflows.
[[nodiscard]] constexpr bool is_positive_definite(const SymmetricMatrix &M) {
    const Triple &d = M.diagonal;
    const Triple &o = M.off_diagonal;
    const float minor = d[0] * d[1] - o[0] * o[0];
    const float determinant =
        d[2] * minor - o[1] * (o[1] * d[1] - o[0] * o[2]) - o[2] * (d[0] * o[2] - o[0] * o[1]);
    return d[0] > 0.0F && minor > 0.0F && determinant > 0.0F;
}

/// diag(bound) − M.
[[nodiscard]] constexpr SymmetricMatrix below(const Triple &bound, const SymmetricMatrix &M) {
    return scaled_sum(-1.0F, M, {bound, {}});
}

} // namespace springdrive::board

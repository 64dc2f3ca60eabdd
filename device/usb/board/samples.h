// What the core exchanges with a chip in every loop.
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

} // namespace springdrive::board

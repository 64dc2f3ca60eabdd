// The one interface to a haptic device, simulated or real. Nothing above it knows which it has.
#pragma once

#include "base/vector.h"
#include "device/device_file.h"

#include <array>
#include <cstdint>

namespace springdrive {

/// What the three amplifiers are asked to do until the next exchange.
struct DeviceCommand {
    Vector3 e_W_V{Vector3::Zero()};                    ///< e_W of (6), per motor
    Vector3 cancelled_resistance_Ohm{Vector3::Zero()}; ///< R̂ of (6), per motor
    Vector3 current_A{Vector3::Zero()}; ///< for a current drive; a spring drive does not look at it

    /// The safe state: e_W = 0 and R̂ = 0, so each winding is shorted through its own resistance
    /// and the device resists like the damper B_R of (5).
    [[nodiscard]] static DeviceCommand braking() { return {}; }
};

enum class DeviceHealth : std::uint8_t {
    ok,
    lost, ///< the device did not answer; counts and currents are the last known
};

/// What the device measured at the moment of the exchange.
struct DeviceState {
    std::array<std::int32_t, 3> counts{}; ///< encoders, zero at θ = 0
    Vector3 current_A{Vector3::Zero()};   ///< winding currents i; τ = k_T i (3)
    DeviceHealth health = DeviceHealth::ok;
};

class HapticDevice {
public:
    HapticDevice() = default;
    HapticDevice(const HapticDevice &) = delete;
    HapticDevice &operator=(const HapticDevice &) = delete;
    virtual ~HapticDevice() = default;

    [[nodiscard]] virtual const DeviceDescription &description() const = 0;

    /// d: whole servo periods between reading θ and the law's answer reaching the winding, beyond
    /// the exchange that carries it.
    [[nodiscard]] virtual double delay_periods() const = 0;

    /// Once per servo tick: sends the command and returns the newest measurement. RT-safe.
    virtual DeviceState exchange(const DeviceCommand &command) noexcept = 0;
};

} // namespace springdrive

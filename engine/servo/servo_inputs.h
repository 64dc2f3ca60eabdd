// The window's inputs to the servo: one plain value, published whole through a mailbox.
#pragma once

#include "device/core/motor/winding_heat.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/control/tuning.h"
#include "engine/servo/safety_limits.h"

#include <array>
#include <cstdint>
#include <optional>

namespace springdrive::servo {

struct LawInputs;
struct ServoSample;

/// What changes a servo's inputs from tick to tick, such as a stimulus that answers to the touch: a
/// mailbox would be late by a frame.
class InputSchedule {
public:
    InputSchedule() = default;
    virtual ~InputSchedule() = default;
    InputSchedule(const InputSchedule &) = delete;
    InputSchedule &operator=(const InputSchedule &) = delete;

    /// After a tick: changes what the law is to do in the next one. `next` is as published.
    /// RT-safe.
    virtual void update(const ServoSample &last, LawInputs &next) noexcept = 0;
};

/// What the law is to do. All of it passes the safety monitor.
struct LawInputs {
    control::Tuning tuning;
    Vector3 excitation_V{Vector3::Zero()}; ///< added to e_W of the law
    /// Instead of touching the surface: x₀ is here, and does not move. A start needs free space, so
    /// set it once the monitor is running, to where the tip is.
    std::optional<Vector3> fixed_x0_m;
};

struct ServoInputs : LawInputs {
    /// Changes the above from tick to tick; null: nothing does. See ServoRun::follow for how long
    /// it must live.
    InputSchedule *schedule = nullptr;
    SafetyLimits limits = unlowered(); ///< may lower the device's limits, never raise them
    const contact::HapticSurface *surface =
        nullptr;                           ///< the touchable surface; owned by the publisher
    std::uint32_t scene_id = 0;            ///< a change puts the proxy at the tip
    double global_alpha_rad2_per_m2 = 0.0; ///< for AlphaMode::global
    /// Number of the last stop that was requested here: larger than that of every stop before,
    /// released or held (SafetyStatus::held_stop).
    std::uint32_t requested_stop = 0;
    std::uint32_t released_stop = 0; ///< number of the last stop that a person saw and released
    /// A change resets a tripped monitor, unless a stop is held that is not released.
    std::uint32_t reset_count = 0;
    bool observes_resistance = false; ///< R̂ follows the windings' resistances
    bool has_inductance = true;       ///< windings have; those of a cheaper simulation do not
    bool release = false; ///< release the device: gains ramp down and stay at zero while set
    /// A running window changes it regularly; zero when running without a window.
    std::uint32_t heartbeat = 0;
    /// A change says that for a time that is not known nobody watched the windings, which are now
    /// at most as hot as before, or as `hottest`.
    std::uint32_t unwatched_count = 0;
    std::array<device::MotorTemperature, 3> hottest{};
};

// The publisher must keep a surface alive until a ServoSample carries the scene_id of a later one.

} // namespace springdrive::servo

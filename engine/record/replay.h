// Puts a record through the control law again, tick by tick: the proof that a record holds all that
// made its voltages, and a way to ask what another tuning would have made of the same motion.
//
//   counts, θ and θ̇_f of the tick before ──► velocity filter, kinematics ──► x, J
//   x, contact, tuning ──► (30), (18) or (23), (10) ──► + carried ──► limits ──► e_W, R̂
//
// What the proxy found, what the monitor decided (its state, ramp and limits) and what a change of
// tuning still carried is taken from the record; all else is computed by the servo's own code. A
// tick whose predecessor is missing is the filter's memory only. Where nothing new was measured,
// the law is asked of the last state again, and the last command stands.
#pragma once

#include "device/core/device_file.h"
#include "engine/control/haptic_law.h"
#include "engine/servo/servo_sample.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace springdrive::record {

/// The part of a sample that the law makes.
struct ReplayedTick {
    control::Configuration now;
    control::LawOutcome found;
    device::DeviceCommand command;
};

/// One quantity of a replay, compared bit by bit.
struct ReplayedQuantity {
    const char *name = "";
    std::uint64_t differing = 0;  ///< ticks
    double greatest = 0.0;        ///< difference, in the quantity's unit
    std::uint64_t first_tick = 0; ///< that differs
};

class Replay {
public:
    /// @param tuning  instead of the record's, if given
    explicit Replay(const device::DeviceDescription &device,
                    const std::optional<control::Tuning> &tuning = std::nullopt);

    /// The next tick of a record: what the law makes of it. Nothing where the one before is missing
    /// and the filter's memory with it, nor after a failed assertion, when no law is asked.
    std::optional<ReplayedTick> take(const servo::ServoSample &sample);

    [[nodiscard]] std::uint64_t replayed() const { return replayed_; }
    [[nodiscard]] std::uint64_t skipped() const { return skipped_; }

    /// θ, θ̇_f, x, η, α, x_Sd, θ_Sd, e_W and R̂ against the record.
    [[nodiscard]] const std::array<ReplayedQuantity, 9> &quantities() const { return quantities_; }

    [[nodiscard]] bool is_identical() const;

private:
    void compare(const servo::ServoSample &sample, const ReplayedTick &replayed);
    void compare(std::size_t quantity, std::uint64_t tick, const Vector3 &recorded,
                 const Vector3 &replayed);

    device::DeviceDescription device_;
    std::optional<control::Tuning> tuning_;
    control::HapticLaw law_;
    std::optional<servo::ServoSample> before_;
    device::DeviceCommand command_ = device::DeviceCommand::braking(); ///< of the tick before
    bool has_measured_ = false; ///< whether anything was, since the servo began
    std::uint64_t replayed_ = 0;
    std::uint64_t skipped_ = 0;
    std::array<ReplayedQuantity, 9> quantities_;
};

} // namespace springdrive::record

// Applies the control law to a record again, tick by tick: proves that a record contains everything
// that determined its voltages, and shows what another tuning would have done with the same motion.
//
//   counts, θ and θ̇_f of the previous tick ──► velocity filter, kinematics ──► x, J
//   x, contact, tuning ──► (30), (18) or (23), (10) ──► + carried ──► limits ──► e_W, R̂
//
// The proxy's contact, the monitor's decisions (state, ramp and limits) and the offset of a
// bumpless transfer are taken from the record; all else is computed by the servo's own code. A tick
// without its predecessor only initialises the filter, which with another tuning continues from its
// own θ̇_f, not the record's. Without a new measurement, the law is evaluated for the last state
// again, and the last command is held.
#pragma once

#include "device/core/device_description.h"
#include "engine/control/haptic_law.h"
#include "engine/servo/servo_sample.h"

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

namespace springdrive::record {

/// The part of a sample that the law computes.
struct ReplayedTick {
    control::Configuration now;
    control::LawOutcome found;
    device::DeviceCommand command;
    servo::ActiveLimits active_limits{}; ///< when the command was computed
};

/// One quantity of a replay, compared bit by bit.
struct ReplayedQuantity {
    const char *name = "";
    std::uint64_t differing = 0;  ///< number of ticks
    double maximum = 0.0;         ///< maximum difference, in the quantity's unit
    std::uint64_t first_tick = 0; ///< the first one that differs
};

class Replay {
public:
    /// @param tuning  replaces the record's, if given
    explicit Replay(const device::DeviceDescription &device,
                    const std::optional<control::Tuning> &tuning = std::nullopt);

    /// The law's result for the next tick of a record. Empty if the previous tick, and with it the
    /// filter's state, is missing, and after a failed assertion, when the law is not evaluated.
    std::optional<ReplayedTick> take(const servo::ServoSample &sample);

    [[nodiscard]] std::uint64_t replayed() const { return replayed_; }
    [[nodiscard]] std::uint64_t skipped() const { return skipped_; }

    /// θ, θ̇_f, x, η, α, x_Sd, θ_Sd, e_W and R̂, compared with the record.
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
    Vector3 theta_rate_rad_per_s_{Vector3::Zero()}; ///< from which the filter continues
    double alpha_before_ = std::numeric_limits<double>::infinity(); ///< see control::AlphaSources
    device::DeviceCommand command_ = device::DeviceCommand::braking(); ///< of the previous tick
    servo::ActiveLimits active_limits_;                                ///< the same
    bool has_measured_ = false; ///< whether there was a measurement since the servo started
    std::uint64_t replayed_ = 0;
    std::uint64_t skipped_ = 0;
    std::array<ReplayedQuantity, 9> quantities_;
};

} // namespace springdrive::record

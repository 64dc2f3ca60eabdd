// A device with a fault: forwards everything to another device and, in given periods, introduces
// one fault.
//
//   servo ── e_W, R̂ ──► [gain, sag] ──► device
//   servo ◄─ measurement ◄── [step, flicker, drift, lateness, reading, silence] ◄── device
//
// It runs on the servo's clock, so that runs repeat, but does not wait for a late servo:
// measurement numbers continue. Faults of the hand enter by its path or target; faults of the
// window are not modelled here.
#pragma once

#include "device/core/forwarding_device.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>

namespace springdrive::rig {

enum class FaultKind : std::uint8_t {
    none,
    lost,            ///< disconnected: the last known state
    absent,          ///< no answer, and not known to be lost
    corrupt,         ///< an answer known to be damaged
    repeated,        ///< the last answer again
    late,            ///< a correct answer, late
    board,           ///< its board reports the faults of size[0], as bits
    not_a_number,    ///< in each current whose size is not zero
    infinite,        ///< the same, with the sign of the size
    count_step,      ///< counts off by the size [counts]
    count_flicker,   ///< the same, in every other period
    count_drift,     ///< counts that run away by the size in each period [counts]
    late_counts,     ///< counts of size[0] periods ago
    count_scale,     ///< counts from where they were, times the size: 0 is frozen, −1 reversed
    count_stuck_bit, ///< this bit of them, where it is not zero, is 0
    current_reading, ///< currents read as the size where it is not zero [A]
    current_offset,  ///< currents read too high by the size [A]
    current_drift,   ///< the same, more in each period [A]
    current_gain,    ///< currents read as 1 + the size times themselves
    sagging_winding, ///< R less by the size [Ω]
    amplifier_gain,  ///< e_W times the size; −1 is a swapped pair of wires
};

struct Fault {
    FaultKind kind = FaultKind::none;
    Vector3 size{Vector3::Zero()};
    /// Its duration in reads.
    std::uint64_t periods = std::numeric_limits<std::uint64_t>::max();
};

class FaultyDevice final : public device::ForwardingDevice {
public:
    using device::ForwardingDevice::ForwardingDevice;

    [[nodiscard]] device::DeviceClock clock() const override { return device::DeviceClock::servo; }
    [[nodiscard]] device::Measurement read() noexcept override;
    void write(const device::DeviceCommand &command) noexcept override;

    /// Unlike a sound simulation it does not know its angles: their zero can be voided.
    [[nodiscard]] bool is_zeroed() const override {
        return !is_void_ && ForwardingDevice::is_zeroed();
    }
    /// From then on the counts are right, whatever steps they had made.
    void zero(const Vector3 &theta_rad) override;

    /// From the next period on, in place of the fault before.
    void commit(const Fault &fault) { commit(fault, periods_); }
    /// From the period of that number on, counted from zero.
    void commit(const Fault &fault, std::uint64_t from_period) {
        fault_ = fault;
        from_ = from_period;
    }
    void clear_fault() { fault_ = {}; }

    /// Periods without a tick of the servo: the amplifiers hold the last command.
    void pass_by(int periods) noexcept;

    /// The device behind this one has been replaced: its numbers continue from the last.
    void continue_numbering() { number_offset_ = last_number_; }

    /// By how much R is too small.
    [[nodiscard]] Vector3 sag_Ohm() const;

    /// The last command written, before any fault of the amplifiers.
    [[nodiscard]] const device::DeviceCommand &last_command() const { return last_command_; }
    /// Reads so far.
    [[nodiscard]] std::uint64_t periods() const { return periods_; }

private:
    [[nodiscard]] FaultKind present() const;
    [[nodiscard]] device::Measurement next_truth() noexcept;
    [[nodiscard]] device::DeviceCommand reaching_the_motors(device::DeviceCommand command) const;
    [[nodiscard]] device::Measurement as_reported(device::Measurement state) const;
    [[nodiscard]] double steps(FaultKind kind) const;

    Fault fault_;
    std::uint64_t from_ = 0;
    std::uint64_t periods_ = 0;
    std::uint64_t last_number_ = 0;
    std::uint64_t number_offset_ = 0;
    device::DeviceCommand last_command_;
    std::atomic<bool> is_void_{false};
    device::Measurement answer_;
    std::array<std::array<std::int32_t, 3>, 512> past_counts_{};
    std::array<std::int32_t, 3> first_counts_{}; ///< when the fault began
};

} // namespace springdrive::rig

// A device with a fault: forwards everything to another device and, in given periods, introduces
// one fault, of those in device/core/faults.h that a driver shows.
//
//   servo ── e_W, R̂ ──► [gain, sag] ──► device
//   servo ◄─ measurement ◄── [step, flicker, drift, lateness, reading, silence] ◄── device
//
// It runs on the servo's clock, so that runs repeat, but does not wait for a late servo:
// measurement numbers continue. Faults of the hand enter by its path or target; faults of the
// window are not modelled here.
#pragma once

#include "device/core/faults.h"
#include "device/core/haptic_device.h"

#include <array>
#include <atomic>
#include <cstdint>

namespace springdrive::rig {

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

    /// In place of the fault before. Its times are whole numbers of reads, from the next one on, in
    /// place of seconds. Kinds of a board's pins have no effect here.
    void commit(device::Fault fault);
    void clear_fault();

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
    [[nodiscard]] device::Measurement next_truth() noexcept;
    void distort(device::Measurement &state, const device::Fault &fault) const;

    device::FaultInjector faults_{1.0}; ///< by reads
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

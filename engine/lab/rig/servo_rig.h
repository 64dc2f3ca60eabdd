// A whole servo in closed loop with a simulated device, ticked explicitly: command limiter and
// safety monitor included, and a device with faults on request. The control law alone in closed
// loop is law_rig.h.
#pragma once

#include "device/core/device_description.h"
#include "device/core/faults.h"
#include "device/core/haptic_device.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/rig/scenario/scenarios.h"
#include "engine/servo/servo_loop.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

namespace springdrive::rig {

/// A device with a fault: forwards everything to another device and, in given periods, introduces
/// one fault, of those in device/core/faults.h that a driver shows.
///
///   servo ── e_W, R̂ ──► [gain, sag] ──► device
///   servo ◄─ measurement ◄── [step, flicker, drift, lateness, reading, silence] ◄── device
///
/// It runs on the servo's clock, so that runs repeat, but does not wait for a late servo:
/// measurement numbers continue. Faults of the hand enter by its path or target; faults of the
/// window are not modelled here.
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

class ServoRig {
public:
    /// @param simulation  its period is the servo's
    /// @param surface     must outlive the rig; none for free space
    /// @throw InputError as `SimulatedPhantom` does
    ServoRig(const device::DeviceDescription &device,
             const simulated::SimulationOptions &simulation, const Vector3 &start_tip_m,
             const contact::HapticSurface *surface = nullptr);
    /// Global α stays to be set in `inputs`, if the tuning uses it.
    /// @throw InputError as `SimulatedPhantom` does
    explicit ServoRig(const Scenario &scenario);
    ServoRig(const ServoRig &) = delete;
    ServoRig &operator=(const ServoRig &) = delete;

    // RT-safe, as far as a simulated device is.
    const servo::ServoSample &tick(const servo::TickTiming &timing = {}) noexcept;
    /// `missed` periods without a tick, then a tick.
    const servo::ServoSample &late_tick(int missed) noexcept;
    /// The ticks of that time.
    void run(double seconds) noexcept;

    /// Removes the hand with its mass; position, rates and currents of the device continue.
    void let_go();

    [[nodiscard]] bool has_tripped() const {
        return last.safety.state == servo::SafetyState::tripped;
    }
    /// What the last tick read.
    [[nodiscard]] const device::Measurement &measured() const { return measured_; }
    [[nodiscard]] const simulated::SimulatedPhantom::Truth &truth() const {
        return phantom_->truth();
    }
    [[nodiscard]] simulated::SimulatedPhantom &phantom() { return *phantom_; }
    [[nodiscard]] FaultyDevice &device() { return device_; }
    [[nodiscard]] const FaultyDevice &device() const { return device_; }
    [[nodiscard]] servo::ServoLoop &loop() { return loop_; }

    servo::ServoInputs inputs; ///< of the next tick
    servo::ServoSample last;

private:
    device::DeviceDescription description_; ///< as given: the phantom's own may count finer
    simulated::SimulationOptions simulation_;
    std::shared_ptr<const contact::HapticSurface> surface_; ///< of a scenario
    std::optional<simulated::SimulatedPhantom> phantom_; ///< always there; made anew in its place
    FaultyDevice device_;
    servo::ServoLoop loop_;
    device::Measurement measured_;
};

} // namespace springdrive::rig

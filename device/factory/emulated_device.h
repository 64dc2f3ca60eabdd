// An emulated board in this process as a device of its own kind, to rehearse what is done with a
// board on USB: zeroing, self-test, unplugging, and all the faults that an emulator has.
//
//   read/write ──► UsbDevice ──► InProcessPort ──► EmulatedBoard ──► SimulatedPhantom ◄── hand
//
// Time passes by the board's frame clock: with each `read` one period, however late the host is. So
// the device is on the servo's clock, as the simulated one is. While its cable is pulled, a period
// passes with each `read`, too.
#pragma once

#include "device/core/haptic_device.h"
#include "device/factory/in_process_port.h"
#include "device/simulated/hand.h"
#include "device/usb/driver/usb_device.h"
#include "device/usb/emulator/emulated_board.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::factory {

inline constexpr const char *kEmulatedSerial = "emulated";

/// Each seed makes another device, with a serial number of its own; of a seed with more digits than
/// fit into a board's identity the last seven tell it.
[[nodiscard]] std::string emulated_serial(std::uint64_t device_seed);

/// What an emulated board is, beyond what its simulated plant is.
struct EmulationOptions {
    std::optional<device::DeviceDescription> truth; ///< if it is not what its host takes it for
    std::vector<device::Fault> faults;              ///< times since it was opened
    double delay_periods = 0.3;                     ///< d that is imposed
};

class EmulatedDevice final : public device::HapticDevice {
public:
    /// Powered up in its zero pose, held there by the hand.
    /// @param simulation  effects, hand and seed of the plant
    /// @throw InputError with one line, for options that it rejects, or a board that does not fit
    EmulatedDevice(const device::DeviceDescription &description, double period_s,
                   const EmulationOptions &options, const simulated::SimulationOptions &simulation);
    ~EmulatedDevice() override { close(); }
    EmulatedDevice(const EmulatedDevice &) = delete;
    EmulatedDevice &operator=(const EmulatedDevice &) = delete;

    [[nodiscard]] const device::DeviceDescription &description() const override {
        return device_->description();
    }
    [[nodiscard]] device::DeviceClock clock() const override { return device::DeviceClock::servo; }
    [[nodiscard]] double delay_periods() const override { return device_->delay_periods(); }
    [[nodiscard]] device::Measurement read() noexcept override;
    void write(const device::DeviceCommand &command) noexcept override { device_->write(command); }
    [[nodiscard]] device::DeviceIdentity identity() const override;
    [[nodiscard]] std::optional<device::LinkStatus> link() const override {
        return device_->link();
    }
    [[nodiscard]] device::Bench *bench() override { return device_->bench(); }
    [[nodiscard]] bool is_zeroed() const override { return device_->is_zeroed(); }
    void set_period(double period_s) override;
    void zero(const Vector3 &theta_rad) override { device_->zero(theta_rad); }
    void close() noexcept override { device_->close(); }
    void reconnect() override;

    /// See UsbDevice.
    void take_calibration(const device::Calibration &calibration) {
        device_->take_calibration(calibration);
    }

    // While no other thread uses the device:

    /// Pulls its cable, or puts it back; a fault can keep it out all the same.
    void set_plugged(bool is_plugged) { is_plugged_ = is_plugged; }
    [[nodiscard]] bool is_plugged() const { return is_plugged_; }

    [[nodiscard]] emulator::EmulatedBoard &board() { return board_; }
    [[nodiscard]] const emulator::EmulatedBoard &board() const { return board_; }

    [[nodiscard]] simulated::HandControl &hand() { return board_.phantom(); }

private:
    void note_cable() noexcept;

    emulator::EmulatedBoard board_;
    InProcessPort *port_ = nullptr; ///< of `device_`
    std::unique_ptr<usb::UsbDevice> device_;
    double period_s_;
    bool is_plugged_ = true;
};

} // namespace springdrive::factory

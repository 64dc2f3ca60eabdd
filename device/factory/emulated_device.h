// An emulated board in this process as a device of its own kind, to rehearse what is done with a
// board on USB: zeroing, self-test, unplugging, and all the faults that an emulator has.
//
//   read/write ──► UsbDevice ──► InProcessPort ──► EmulatedBoard ──► SimulatedPhantom ◄── hand
//
// Time passes by the board's frame clock: with each `read` one period, however late the host is. So
// the device is on the servo's clock, as the simulated one is. While its cable is pulled, a period
// passes with each `read`, too.
#pragma once

#include "base/input_error.h"
#include "device/core/haptic_device.h"
#include "device/simulated/hand.h"
#include "device/usb/driver/board_port.h"
#include "device/usb/driver/usb_device.h"
#include "device/usb/emulator/emulated_board.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::factory {

/// A port to an emulated board in the same process, by the board's frame clock: time stands still
/// while the host computes, and a report that does not come is known at once not to come.
class InProcessPort : public usb::BoardPort {
public:
    /// @param board  must outlive the port
    explicit InProcessPort(emulator::EmulatedBoard &board) : board_(board) {}

    bool is_plugged = true; ///< `unplug` and this replace a cable
    bool is_high_speed = true;

    void unplug() {
        is_plugged = false;
        is_connected_ = false;
        board_.detach();
    }
    /// Time by the wall clock, without the host.
    void pass(double seconds) {
        constexpr double kStep_s = 1e-3;
        for (int i = 0; i < static_cast<int>(seconds / kStep_s); ++i) {
            board_.pass(kStep_s);
        }
    }

    bool send(const usb::Frame &frame) noexcept override {
        if (is_connected_) {
            board_.put(frame);
        }
        return is_connected_;
    }
    bool receive(usb::Packet &packet, double deadline_s) noexcept override {
        packet.size = is_connected_ ? board_.take(packet.data) : 0;
        if (packet.size == 0) {
            waited_s_ += std::max(0.0, deadline_s - now_s());
            return false;
        }
        packet.arrived_s = now_s();
        return true;
    }
    [[nodiscard]] bool is_connected() const noexcept override { return is_connected_; }
    [[nodiscard]] double now_s() const noexcept override { return board_.time_s() + waited_s_; }
    std::size_t control_in(usb::Kind request, std::uint16_t value,
                           std::span<std::uint8_t> answer) override {
        require_connection();
        std::array<std::uint8_t, board::kMaxPayload> payload{};
        const std::size_t size = std::min(
            board_.control_in(static_cast<std::uint8_t>(request), value, payload), answer.size());
        std::copy_n(payload.begin(), size, answer.begin());
        return size;
    }
    bool control_out(usb::Kind request, std::uint16_t value,
                     std::span<const std::uint8_t> payload) override {
        require_connection();
        return board_.control_out(static_cast<std::uint8_t>(request), value, payload);
    }
    void close() noexcept override {
        if (is_connected_) {
            is_connected_ = false;
            board_.detach();
        }
    }
    void open(const std::string & /*serial*/) override {
        if (!is_plugged) {
            throw InputError("no USB board is connected");
        }
        is_connected_ = true;
        board_.attach(is_high_speed);
    }
    [[nodiscard]] std::string_view speed() const override {
        return is_high_speed ? "high speed (480 Mbit/s)" : "full speed (12 Mbit/s)";
    }

protected:
    emulator::EmulatedBoard &board_;

private:
    void require_connection() const {
        if (!is_connected_) {
            throw InputError("the USB board: it does not answer");
        }
    }

    bool is_connected_ = false;
    double waited_s_ = 0.0;
};

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

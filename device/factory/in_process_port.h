// A port to an emulated board in the same process.
#pragma once

#include "base/input_error.h"
#include "device/usb/driver/board_port.h"
#include "device/usb/emulator/emulated_board.h"

#include <algorithm>
#include <array>
#include <string>

namespace springdrive::factory {

/// By the board's frame clock: time stands still while the host computes, and a report that does
/// not come is known at once not to come.
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

} // namespace springdrive::factory

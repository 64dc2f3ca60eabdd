// A port to an emulated board in the same process.
#pragma once

#include "base/input_error.h"
#include "device/usb/driver/board_port.h"
#include "device/usb/emulator/emulated_board.h"

#include <algorithm>
#include <deque>
#include <random>
#include <string>

namespace springdrive::testing {

/// As much of the board's answer as the host asks for.
inline std::size_t control_in_of(emulator::EmulatedBoard &board, usb::Kind request,
                                 std::uint16_t value, std::span<std::uint8_t> answer) {
    std::array<std::uint8_t, board::kLargestPayload> payload{};
    const std::size_t size = std::min(
        board.control_in(static_cast<std::uint8_t>(request), value, payload), answer.size());
    std::copy_n(payload.begin(), size, answer.begin());
    return size;
}

/// By the board's frame clock: time stands still while the host computes, and a report that does
/// not come is known at once not to come.
class EmulatedPort final : public usb::BoardPort {
public:
    /// @param board  must outlive the port
    explicit EmulatedPort(emulator::EmulatedBoard &board) : board_(board) {}

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
        return control_in_of(board_, request, value, answer);
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

private:
    void require_connection() const {
        if (!is_connected_) {
            throw InputError("the USB board: it does not answer");
        }
    }

    emulator::EmulatedBoard &board_;
    bool is_connected_ = false;
    double waited_s_ = 0.0;
};

/// By a clock that passes for host and board alike, with packets that need time.
class TimedPort final : public usb::BoardPort {
public:
    struct Way {
        double least_s = 60e-6; ///< of a packet, each way
        double most_s = 120e-6; ///< the same
        double drift = 0.0;     ///< by which the board's clock is faster
        std::uint64_t seed = 1;
    };

    TimedPort(emulator::EmulatedBoard &board, const Way &way)
        : board_(board), way_(way), random_(way.seed) {}

    /// The host does nothing until then.
    void sleep_until(double time_s) {
        while (now_s_ < time_s) {
            step();
        }
    }

    bool send(const usb::Frame &frame) noexcept override {
        out_.push_back({now_s_ + delay_s(out_), frame, frame.size()});
        return true;
    }
    bool receive(usb::Packet &packet, double deadline_s) noexcept override {
        while (in_.empty() || in_.front().at_s > now_s_) {
            if (now_s_ >= deadline_s) {
                return false;
            }
            step();
        }
        packet = {in_.front().data, in_.front().size, in_.front().at_s};
        in_.pop_front();
        return true;
    }
    [[nodiscard]] bool is_connected() const noexcept override { return is_open_; }
    [[nodiscard]] double now_s() const noexcept override { return now_s_; }
    std::size_t control_in(usb::Kind request, std::uint16_t value,
                           std::span<std::uint8_t> answer) override {
        return control_in_of(board_, request, value, answer);
    }
    bool control_out(usb::Kind request, std::uint16_t value,
                     std::span<const std::uint8_t> payload) override {
        return board_.control_out(static_cast<std::uint8_t>(request), value, payload);
    }
    void close() noexcept override {
        is_open_ = false;
        board_.detach();
    }
    void open(const std::string & /*serial*/) override {
        is_open_ = true;
        board_.attach(true);
    }
    [[nodiscard]] std::string_view speed() const override { return "high speed (480 Mbit/s)"; }

private:
    struct UnderWay {
        double at_s = 0.0; ///< of its arrival
        usb::Frame data{};
        std::size_t size = 0;
    };

    /// Packets do not overtake one another.
    double delay_s(const std::deque<UnderWay> &queue) {
        const double delay_s = std::uniform_real_distribution(way_.least_s, way_.most_s)(random_);
        return queue.empty() ? delay_s : std::max(delay_s, queue.back().at_s - now_s_);
    }

    void step() {
        constexpr double kStep_s = 5e-6;
        now_s_ += kStep_s;
        while (!out_.empty() && out_.front().at_s <= now_s_) {
            board_.put(std::span(out_.front().data).first(out_.front().size));
            out_.pop_front();
        }
        board_.pass(kStep_s * (1.0 + way_.drift));
        usb::Frame frame;
        if (const std::size_t size = board_.take(frame); size > 0) {
            in_.push_back({now_s_ + delay_s(in_), frame, size});
        }
    }

    emulator::EmulatedBoard &board_;
    Way way_;
    std::mt19937_64 random_;
    double now_s_ = 0.0;
    bool is_open_ = false;
    std::deque<UnderWay> out_;
    std::deque<UnderWay> in_;
};

} // namespace springdrive::testing

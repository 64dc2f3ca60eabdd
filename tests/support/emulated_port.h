// Ports to an emulated board in the same process.
#pragma once

#include "device/factory/emulated_device.h"

#include <deque>
#include <random>

namespace springdrive::testing {

using EmulatedPort = factory::InProcessPort;

/// By a clock that passes for host and board alike, with packets that need time.
class TimedPort final : public EmulatedPort {
public:
    struct Way {
        double min_s = 60e-6;  ///< of a packet, each way
        double max_s = 120e-6; ///< the same
        double drift = 0.0;    ///< by which the board's clock is faster
        std::uint64_t seed = 1;
    };

    TimedPort(emulator::EmulatedBoard &board, const Way &way)
        : EmulatedPort(board), way_(way), random_(way.seed) {}

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
    [[nodiscard]] double now_s() const noexcept override { return now_s_; }

private:
    struct UnderWay {
        double at_s = 0.0; ///< of its arrival
        usb::Frame data{};
        std::size_t size = 0;
    };

    /// Packets do not overtake one another.
    double delay_s(const std::deque<UnderWay> &queue) {
        const double delay_s = std::uniform_real_distribution(way_.min_s, way_.max_s)(random_);
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

    Way way_;
    std::mt19937_64 random_;
    double now_s_ = 0.0;
    std::deque<UnderWay> out_;
    std::deque<UnderWay> in_;
};

} // namespace springdrive::testing

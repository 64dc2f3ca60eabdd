// The whole core: the amplifiers' loop, the board's end of the protocol, and what they exchange.
// Allocates nothing, blocks nowhere; its state is this object, and the same calls give the same
// answers. `tick` may interrupt the other functions, which may not interrupt one another or it.
#pragma once

#include "device/usb/board/link.h"
#include "device/usb/board/loop.h"

namespace springdrive::board {

class Board {
public:
    Board(const BoardSettings &settings, const usb::Identity &identity)
        : loop_(settings), link_(settings, identity) {
        publish();
    }

    /// One loop of the amplifiers.
    [[nodiscard]] BridgeOrder tick(const Samples &samples) {
        return loop_.tick(samples, orders_.newest(), status_);
    }

    /// A packet from the OUT endpoint, and the board time of its arrival.
    usb::FrameStatus receive(const std::uint8_t *data, std::size_t size,
                             std::uint32_t arrived_at_us) {
        const usb::FrameStatus result = link_.receive(data, size, arrived_at_us, status_.copy());
        if (result == usb::FrameStatus::ok) {
            publish();
        }
        return result;
    }

    /// The packet for the IN endpoint, if a report is new.
    [[nodiscard]] bool take_report(usb::Frame &frame) {
        return link_.take_report(frame, status_.copy());
    }

    /// @param request  bRequest, of a request with bmRequestType usb::kRequestOut
    /// @return false: to be stalled
    [[nodiscard]] bool control_out(std::uint8_t request, const std::uint8_t *data,
                                   std::size_t size) {
        LoopStatus status = status_.copy();
        status.report.state = loop_.state(); // a report may be 50 ms old
        const bool is_accepted = link_.control_out(request, data, size, status);
        publish();
        return is_accepted;
    }

    /// @param request  bRequest, of a request with bmRequestType usb::kRequestIn, and its wValue
    /// @param payload  kMaxPayload bytes
    /// @return how many of them to send; 0: to be stalled
    [[nodiscard]] std::size_t control_in(std::uint8_t request, std::uint16_t value,
                                         std::uint8_t *payload) const {
        return link_.control_in(request, value, payload, status_.copy());
    }

    /// The bus was reset or suspended, or the cable pulled: brakes at once.
    void disconnect() {
        link_.disconnect();
        publish();
    }
    void set_speed(bool is_high_speed) { link_.set_speed(is_high_speed); }

    void load(const usb::CalibrationBlock &block) {
        link_.load(block);
        publish();
    }
    /// Storing a block may stop the loop: there is none while a motor is driven, and from when the
    /// host wrote it until `end_store` no command to drive is applied.
    [[nodiscard]] bool take_block_to_store(usb::CalibrationBlock &block) {
        return loop_.state() != State::driving && loop_.state() != State::testing &&
               link_.take_block_to_store(block);
    }
    /// @param is_stored  whether the chip kept it; else reading it back is refused from now on
    void end_store(std::uint16_t index, bool is_stored) {
        link_.end_store(index, is_stored);
        publish();
    }

    /// Whether the loop has run since the last call.
    [[nodiscard]] bool loop_has_run() {
        const std::uint32_t loops = loop_.loops();
        const bool has_run = loops != loops_seen_;
        loops_seen_ = loops;
        return has_run;
    }

    [[nodiscard]] const Loop &loop() const { return loop_; }

private:
    void publish() {
        link_.count_change();
        orders_.publish(link_.orders());
    }

    Loop loop_;
    Link link_;
    Published<Orders> orders_;
    Published<LoopStatus> status_;
    std::uint32_t loops_seen_ = 0;
};

} // namespace springdrive::board

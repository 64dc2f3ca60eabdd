// The whole core: the amplifiers' loop, the board's end of the protocol, and what they exchange;
// and what a firmware implements for its chip. Allocates nothing, blocks nowhere; its state is one
// object, and the same calls give the same answers. `tick` may interrupt the other functions, which
// may not interrupt one another or it.
#pragma once

#include "device/usb/board/link.h"
#include "device/usb/board/loop.h"

#include <concepts>

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

/// All that a board's firmware implements for its chip. The core handles values only: it computes a
/// BridgeOrder from Samples, and one Frame from another. `Hardware` is a concept, not an interface
/// with virtual functions or a table of function pointers: the amplifiers' loop is then compiled
/// together with the chip's register accesses, and a missing function is an error of the compiler.
///
///   loop interrupt, highest priority:   run_loop(hardware, board)        at settings.loop_rate_hz
///   USB interrupt or main program:      board.receive, board.take_report, board.control_*
///   main program:                       run_background(hardware, board)  at least every 10 ms
template <class Chip>
concept Hardware = requires(Chip &chip, const BridgeOrder &order, usb::CalibrationBlock &block,
                            const usb::CalibrationBlock &stored, std::uint16_t index) {
    /// Reads everything at the start of a loop, currents first: sampled in the middle of a PWM
    /// period, where the ripple of the current is zero.
    { chip.sample() } -> std::same_as<Samples>;
    /// Sets the power stages for the next PWM period, all channels at once.
    { chip.apply(order) } -> std::same_as<void>;
    /// Board time: a free-running counter of microseconds, modulo 2^32.
    { chip.now_us() } -> std::same_as<std::uint32_t>;
    /// Restarts the chip's own watchdog, which resets the chip after 20 ms.
    { chip.kick_watchdog() } -> std::same_as<void>;
    /// Calibration blocks in non-volatile memory; false if there is none, or its checksum is wrong.
    { chip.load_block(index, block) } -> std::same_as<bool>;
    { chip.store_block(stored) } -> std::same_as<bool>;
};

/// Once, before the loop's interrupt is enabled.
template <Hardware Chip> void start(Chip &chip, Board &board) {
    chip.apply(BridgeOrder::opening());
    for (std::uint16_t index = 0; index < kCalibrationBlocks; ++index) {
        usb::CalibrationBlock block;
        block.index = index;
        if (chip.load_block(index, block)) {
            board.load(block);
        }
    }
}

template <Hardware Chip> void run_loop(Chip &chip, Board &board) {
    chip.apply(board.tick(chip.sample()));
}

/// The chip's watchdog is restarted only while the loop runs; the windings are open after a reset.
template <Hardware Chip> void run_background(Chip &chip, Board &board) {
    if (board.loop_has_run()) {
        chip.kick_watchdog();
    }
    usb::CalibrationBlock block;
    if (board.take_block_to_store(block)) {
        board.end_store(block.index, chip.store_block(block));
    }
}

} // namespace springdrive::board

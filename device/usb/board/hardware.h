// All that a board's firmware implements for its chip. The core handles values only: it computes a
// BridgeOrder from Samples, and one Frame from another. `Hardware` is a concept, not an interface
// with virtual functions or a table of function pointers: the amplifiers' loop is then compiled
// together with the chip's register accesses, and a missing function is an error of the compiler.
//
//   loop interrupt, highest priority:   run_loop(hardware, board)        at settings.loop_rate_hz
//   USB interrupt or main program:      board.receive, board.take_report, board.control_*
//   main program:                       run_background(hardware, board)  at least every 10 ms
#pragma once

#include "device/usb/board/board.h"

#include <concepts>

namespace springdrive::board {

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

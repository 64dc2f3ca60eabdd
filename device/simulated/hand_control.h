// Controls of the simulated hand that holds a device: a simulated one, or that behind an emulated
// board.
#pragma once

#include "base/vector.h"
#include "device/core/hand_parameters.h"
#include "device/simulated/hand_path.h"
#include "device/simulated/hand_stimulus.h"

namespace springdrive::simulated {

class HandControl {
public:
    HandControl() = default;
    HandControl(const HandControl &) = delete;
    HandControl &operator=(const HandControl &) = delete;
    virtual ~HandControl() = default;

    /// Sets the hand's target from now on [m]; the hand moves there smoothly. One thread at a time,
    /// any thread; takes effect once the hand's path, if it has one, has ended.
    virtual void set_hand_target(const Vector3 &target_m) noexcept = 0;

    /// Starts a test signal of the hand, if its number is another one than before. One thread at a
    /// time, any thread.
    virtual void play(const HandStimulus &stimulus) noexcept = 0;

    /// From the next period on, how firm the hand is. One thread at a time, any thread.
    /// @throw InputError for parameters that are out of range
    virtual void hold_with(const device::HandParameters &hand) = 0;

    // While no other thread uses the device:

    /// The hand follows this path from now on: its time 0 is now.
    virtual void follow(HandPath path) = 0;

    /// Where the hand's spring pulls to now, without a test signal [m].
    [[nodiscard]] virtual Vector3 hand_m() const = 0;
};

} // namespace springdrive::simulated

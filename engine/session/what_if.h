// What the law would have commanded during a recorded motion with another tuning, and the currents
// and forces that would have followed.
//
//   recorded tick, tuning ──► record::Replay ──► θ̇_f, η, α, x_Sd, θ_Sd, e_W, R̂
//   e_W, R̂ after the delay d; recorded θ ──► windings (11) ──► i ──► tip force (3), (22)
//
// The motion is the recorded one, although the hand would have moved otherwise. So the commands are
// exact for this motion, but only for it; currents and force are an open-loop prediction, in which
// nothing corrects what is not known: R, k_T and the sensor's offset are what the servo knew of
// them in that tick (of the device file, if it did not observe them), and each rotor turns with the
// mean velocity between two readings of its encoder. A reading is wrong by up to half a count,
// which makes up to k_T/L times a count of current. All else is as recorded, including the proxy's
// contact, the monitor's decisions and the offset of e_W after changes of the record's own tuning.
#pragma once

#include "device/core/haptic_device.h"
#include "device/core/split_delay.h"
#include "engine/record/replay.h"
#include "engine/session/record.h"

#include <cstdint>
#include <deque>
#include <optional>

namespace springdrive::session {

/// Predicts the currents of windings that get other commands than recorded.
class PredictedCurrents {
public:
    /// @param delay_periods  d of the recorded device
    PredictedCurrents(const device::DeviceDescription &device, double delay_periods);

    /// The currents as measured at the next tick of a record, with the sensors' offsets [A]: the
    /// recorded ones until all commands are known that acted since the measurement before, again
    /// after missing ticks, and while the monitor lets no command pass.
    [[nodiscard]] Vector3 at(const servo::ServoSample &recorded);

    /// Before `at`: from this tick on.
    void set_delay(double delay_periods);

    /// Once a tick, after `at`: the command of this tick.
    void note(const device::DeviceCommand &command) { commands_.push_back(command); }

private:
    [[nodiscard]] bool follows(const servo::ServoSample &recorded) const;
    [[nodiscard]] int periods_until(const servo::ServoSample &recorded);
    void run(const servo::ServoSample &recorded, int periods);
    void drive(const device::DeviceCommand &command, const servo::ServoSample &recorded,
               double duration_s);

    device::DeviceDescription device_;
    device::SplitDelay delay_;
    std::optional<std::uint64_t> last_tick_;
    std::optional<servo::ServoSample> measured_; ///< the last tick with a new measurement
    Vector3 current_A_{Vector3::Zero()};         ///< at that time, without the sensors' offsets
    std::deque<device::DeviceCommand> commands_; ///< one per period, the newest last
};

/// Computes consecutive ticks of a record again with another tuning.
class WhatIf {
public:
    WhatIf(const device::DeviceDescription &device, double delay_periods,
           const control::Tuning &tuning);

    /// From the next tick on.
    void set_delay(double delay_periods) { currents_.set_delay(delay_periods); }

    /// The next tick with what this tuning changes. A tick that cannot be replayed stays as it is,
    /// such as the first one and those after missing ticks.
    [[nodiscard]] servo::ServoSample of(const servo::ServoSample &recorded);

private:
    void take_law(const record::ReplayedTick &tick, servo::ServoSample &answer) const;
    void take_force(const record::ReplayedTick &tick, servo::ServoSample &answer) const;

    control::Tuning tuning_;
    control::HapticLaw law_;
    record::Replay replay_;
    PredictedCurrents currents_;
};

/// The rows of a range with another tuning: of the same times as in the record, but numbered from
/// the range's first. The rows before it are used as far as they matter. Any thread.
/// @pre the range is in the store
/// @throw Cancelled soon after this thread's work was cancelled
[[nodiscard]] record::ChannelStore what_if(const Record &record, const control::Tuning &tuning,
                                           const RowRange &rows);

} // namespace springdrive::session

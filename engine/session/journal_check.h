#pragma once

#include "device/core/device_description.h"
#include "engine/control/tuning.h"
#include "engine/servo/servo_sample.h"
#include "engine/session/run_folder.h"

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <vector>

namespace springdrive::session {

/// Compares the tunings of a record with the journal of its run.
///
/// The tuning of each tick follows from that of the previous one and from the tuning wanted by the
/// journal, by the servo's own transition: at rest to the last bit, and on the way to a new tuning
/// within the rounding of the ticks' times. Exact is also from when: a change is entered with the
/// time of the last tick that the window had received, so it is active in none up to that one. It
/// reaches the servo within a frame of the window. Of changes within one frame, only the last need
/// reach it. What a control set while it was moved is not in the journal, only where it ended.
class JournalCheck {
public:
    /// @param start_s  the session's time at which the record's time is 0
    JournalCheck(const RunFacts &run, double start_s, device::DeviceDescription device);

    /// @param sample  of the record, in its order
    void take(const servo::ServoSample &sample);

    [[nodiscard]] bool is_fine() const { return differing_ == 0; }
    /// Ticks.
    [[nodiscard]] std::uint64_t compared() const { return agreeing_ + moved_ + differing_; }

    /// A line of what was found.
    void print_to(std::ostream &out) const;

private:
    struct Tick {
        std::uint64_t tick = 0;
        double time_s = 0.0; ///< of the record
        control::Tuning tuning;
    };

    bool follows_journal(const Tick &before, double now_s);
    [[nodiscard]] bool is_moved(double now_s) const;
    [[nodiscard]] bool is_on_the_way(const Tick &before, const control::Tuning &wanted) const;
    [[nodiscard]] control::Tuning tuning_after(const control::Tuning &before,
                                               const control::Tuning &wanted,
                                               double period_s) const;

    std::vector<TuningEvent> journal_;
    double until_s_;
    double start_s_;
    device::DeviceDescription device_;
    std::optional<Tick> before_; ///< the latest tick
    std::size_t begun_ = 0;      ///< events before the latest tick
    std::size_t reached_ = 0;    ///< the event that is wanted
    std::uint64_t agreeing_ = 0;
    std::uint64_t moved_ = 0;
    std::uint64_t unchecked_ = 0;
    std::uint64_t differing_ = 0;
    std::uint64_t first_differing_ = 0;
    double longest_delay_s_ = 0.0;
};

} // namespace springdrive::session

// Stops of the device in a sitting: each is stored with the trial in which it was, or noted; and
// when the motors may run again.
#pragma once

#include "engine/session/session.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace springdrive::app::study_screen {

class DeviceStops {
public:
    /// @param note  stores what it is told of a stop outside of trials
    DeviceStops(session::Session &session, std::function<void(const std::string &)> note);

    /// Every frame, and before what is known of the device is relied on: with all that the servo
    /// has published. A stop that somebody wants holds, whatever else has stopped the device
    /// before: the monitor knows only the first one.
    void watch();

    /// A stop from now on is the trial's.
    void begin_trial();
    /// @param is_stored  with the trial; otherwise it is noted now
    void end_trial(bool is_stored);

    /// Somebody lets the device go on: of a stop that is there, not of a later one.
    void let_go_on() { may_go_on_ = !has_news_; }
    /// The calm after a stop begins anew.
    void begin_calm();
    /// Every frame of a stop: resets the device after one by hand when somebody lets it go on,
    /// after another when it was calm for a while.
    void reset_when_allowed();

    /// Of the session so far.
    [[nodiscard]] int count() const { return count_; }

private:
    /// Until somebody lets the device go on, also in a later sitting.
    [[nodiscard]] bool is_by_hand() const;

    session::Session &session_;
    std::function<void(const std::string &)> note_;
    std::uint32_t presses_; ///< of the emergency stop, so far
    int count_ = 0;
    bool was_tripped_ = false;
    bool has_news_ = false; ///< a stop that nobody has seen yet
    bool may_go_on_ = false;
    bool is_in_trial_ = false;
    std::optional<std::string> of_trial_; ///< the stop in the present one
    bool is_reset_ = false;               ///< and not yet seen to run
    double calm_from_s_ = 0.0;
    double reset_s_ = 0.0; ///< the last time
};

} // namespace springdrive::app::study_screen

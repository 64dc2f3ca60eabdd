// Stops of the device in a sitting: each is stored with the trial in which it was, or noted; and
// when the device is reset after one that nobody requested.
#pragma once

#include "engine/session/session.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace springdrive::app::study_screen {

class DeviceStops {
public:
    /// @param resets_itself  after a calm, unless a requested stop is held
    /// @param note           stores what it is told of a stop outside of trials
    DeviceStops(session::Session &session, bool resets_itself,
                std::function<void(const std::string &)> note);

    /// Every frame, and before what is known of the device is relied on: with all that the servo
    /// has published.
    void watch();

    /// A stop from now on is the trial's.
    void begin_trial();
    /// Nothing outside of a trial. @param is_stored  with the trial; otherwise it is noted now
    void end_trial(bool is_stored);

    /// A person lets the device go on.
    void let_go_on();
    /// The calm after a stop begins anew.
    void begin_calm();
    /// Every frame of a stop: resets the device when it was calm for a while.
    void reset_when_calm();

    /// Of the session so far.
    [[nodiscard]] int count() const { return count_; }

private:
    void note_reset();

    session::Session &session_;
    bool resets_itself_;
    std::function<void(const std::string &)> note_;
    int count_ = 0;
    bool was_tripped_ = false;
    std::uint32_t held_stop_ = 0; ///< as last seen
    bool is_in_trial_ = false;
    std::optional<std::string> of_trial_; ///< the stop in the present one
    bool is_reset_ = false;               ///< and not yet seen to run
    double calm_from_s_ = 0.0;
    double reset_s_ = 0.0; ///< the last time
};

} // namespace springdrive::app::study_screen

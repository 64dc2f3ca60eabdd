#include "app/exhibit/healing.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace springdrive::app::exhibit {

using servo::SafetyState;
using servo::TripCause;

std::string_view name_of(Condition condition) {
    constexpr std::array<std::string_view, 8> kNames{
        "well", "lost", "let go", "pause", "asks go on", "lift", "needs staff", "needs zeroing"};
    return kNames[static_cast<std::size_t>(condition)];
}

Remedy Healing::update(const HealingNow &now) {
    if (now.state == SafetyState::tripped) {
        running_since_s_.reset();
        caught_since_s_.reset();
        return heal(now);
    }
    calm_since_s_.reset();
    return watch(now);
}

/// While it is stopped.
Remedy Healing::heal(const HealingNow &now) {
    const bool is_stubborn = resets_ >= kStubborn;
    if (servo::is_final(now.cause)) {
        condition_ = Condition::needs_staff;
        return Remedy::none;
    }
    if (now.is_lost) {
        condition_ = Condition::lost;
        calm_since_s_.reset();
        return Remedy::none;
    }
    if (now.cause == TripCause::emergency_stop && now.is_real) {
        condition_ = Condition::asks_go_on;
        return Remedy::none;
    }
    if (now.hand_is_held || now.is_touching) {
        condition_ = is_stubborn ? Condition::needs_staff : Condition::let_go;
        calm_since_s_.reset();
        return now.hand_is_held ? Remedy::none : Remedy::lift_hand;
    }
    calm_since_s_ = calm_since_s_.value_or(now.time_s);
    const double pause_s = is_stubborn                              ? kStubbornPause_s
                           : now.cause == TripCause::emergency_stop ? kPauseAfterStop_s
                                                                    : kPause_s;
    goes_on_in_s_ = std::max(0.0, *calm_since_s_ + pause_s - now.time_s);
    condition_ = is_stubborn ? Condition::needs_staff : Condition::pause;
    if (goes_on_in_s_ > 0.0) {
        return Remedy::none;
    }
    calm_since_s_ = now.time_s; // if it is in vain
    if (now.cause != TripCause::emergency_stop && now.cause != TripCause::device_lost) {
        resets_ = std::min(resets_ + 1, kStubborn); // those two come from people, not from a fault
    }
    return Remedy::reset;
}

/// While it is not.
Remedy Healing::watch(const HealingNow &now) {
    if (now.state == SafetyState::running) {
        running_since_s_ = running_since_s_.value_or(now.time_s);
        if (now.time_s - *running_since_s_ >= kProven_s) {
            resets_ = 0;
        }
    } else {
        running_since_s_.reset();
    }
    condition_ = Condition::well;
    if (!now.is_zeroed || now.is_held_back) {
        condition_ = now.is_held_back ? Condition::needs_staff : Condition::needs_zeroing;
        return Remedy::none;
    }
    const bool is_caught =
        now.state == SafetyState::waiting ? now.is_touching || now.is_inside : now.is_inside;
    if (!is_caught) {
        caught_since_s_.reset();
        return Remedy::none;
    }
    condition_ = Condition::lift;
    caught_since_s_ = now.hand_is_held ? now.time_s : caught_since_s_.value_or(now.time_s);
    return now.time_s - *caught_since_s_ >= kLift_s ? Remedy::lift_hand : Remedy::none;
}

} // namespace springdrive::app::exhibit

#include "app/exhibit/trip_recovery.h"

#include <algorithm>

namespace springdrive::app::exhibit {

using servo::SafetyState;
using servo::TripCause;

RecoveryState recovery_of(const session::Session &session) {
    const servo::ServoSample &latest = session.latest();
    RecoveryState now;
    now.state = latest.safety.state;
    now.cause = latest.safety.cause;
    now.is_stop_held = session.servo().is_held_stopped();
    now.can_reach_a_hand = session.device().device().can_reach_a_hand();
    now.is_lost = latest.health == device::DeviceHealth::lost;
    now.is_zeroed = session.is_zeroed() || now.is_lost;
    now.is_limited = session.is_kept_released();
    now.is_touching = latest.contact.touching;
    return now;
}

Remedy TripRecovery::update(const RecoveryState &now) {
    if (now.state == SafetyState::tripped) {
        running_since_s_.reset();
        caught_since_s_.reset();
        return recover(now);
    }
    calm_since_s_.reset();
    return watch(now);
}

/// While it is stopped.
Remedy TripRecovery::recover(const RecoveryState &now) {
    const auto waits = [this](Condition condition) {
        condition_ = condition;
        calm_since_s_.reset();
        return Remedy::none;
    };
    if (servo::is_final(now.cause)) {
        return waits(Condition::needs_staff);
    }
    if (now.is_lost) {
        return waits(Condition::lost);
    }
    if (now.is_stop_held || now.can_reach_a_hand || resets_ >= kMaxResets) {
        return waits(Condition::asks_go_on);
    }
    if (now.hand_is_held || now.is_touching) {
        static_cast<void>(waits(Condition::let_go));
        return now.hand_is_held ? Remedy::none : Remedy::retract_hand;
    }
    calm_since_s_ = calm_since_s_.value_or(now.time_s);
    goes_on_in_s_ = std::max(0.0, *calm_since_s_ + kPause_s - now.time_s);
    condition_ = Condition::pause;
    if (goes_on_in_s_ > 0.0) {
        return Remedy::none;
    }
    calm_since_s_ = now.time_s; // if it is in vain
    ++resets_;
    return Remedy::reset;
}

/// While it is not.
Remedy TripRecovery::watch(const RecoveryState &now) {
    if (now.state == SafetyState::running) {
        running_since_s_ = running_since_s_.value_or(now.time_s);
        if (now.time_s - *running_since_s_ >= kProven_s) {
            resets_ = 0;
        }
    } else {
        running_since_s_.reset();
    }
    condition_ = Condition::well;
    if (!now.is_zeroed || now.is_limited) {
        condition_ = now.is_limited ? Condition::needs_staff : Condition::needs_zeroing;
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
    return now.time_s - *caught_since_s_ >= kLift_s ? Remedy::retract_hand : Remedy::none;
}

} // namespace springdrive::app::exhibit

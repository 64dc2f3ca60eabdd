// The safety monitor at an exhibit, where anybody may hold the device: its limits, and how an
// exhibit goes on after a stop, as pure logic: a simulation by itself, a few times; a device that
// can reach a hand, and after a requested stop any, when a person lets it go on.
//
//   stopped ──hand let go, tip free──► a pause ──► reset ──► lift the tip ──► running
//      └─────a person: go on───────────────────────► reset
#pragma once

#include "engine/servo/safety_limits.h"
#include "engine/session/session.h"

#include <cstdint>
#include <optional>

namespace springdrive::app::exhibit {

/// They are set before the servo starts, and nothing in a kiosk's window changes them. A limit of
/// the device's file that is lower still counts; all others are those of the file.
[[nodiscard]] constexpr servo::SafetyLimits kiosk_limits() {
    servo::SafetyLimits limits = servo::unlowered();
    limits.voltage_V = 9.0;
    limits.current_A = 4.0;
    limits.tip_force_N = 5.0;
    limits.tip_speed_m_per_s = 1.2;
    limits.winding_C = 90.0;
    return limits;
}

/// What the recovery depends on, of one frame.
struct RecoveryState {
    double time_s = 0.0;
    servo::SafetyState state = servo::SafetyState::waiting;
    servo::TripCause cause = servo::TripCause::none;
    bool is_stop_held = false; ///< somebody requested it
    bool can_reach_a_hand = false;
    bool is_lost = false;      ///< the device does not answer
    bool is_zeroed = true;     ///< its angles are known
    bool is_limited = false;   ///< the device only brakes, since it failed its commissioning
    bool is_touching = false;  ///< a surface
    bool is_inside = false;    ///< the tip lies in a solid
    bool hand_is_held = false; ///< by the visitor
};

/// What a session tells of itself: all but time, hand, and tip inside.
[[nodiscard]] RecoveryState recovery_of(const session::Session &session);

/// What the visitor is told.
enum class Condition : std::uint8_t {
    well,
    lost,          ///< it is connected again once it is there
    let_go,        ///< the hand is to be let go, or the tip lifted, first
    pause,         ///< it goes on in `goes_on_in_s`
    asks_go_on,    ///< a person has to say that it may go on
    lift,          ///< the motors wait for the tip to be lifted off
    needs_staff,   ///< no reset helps
    needs_zeroing, ///< by the staff
};

enum class Remedy : std::uint8_t { none, reset, retract_hand };

/// How an exhibit goes on after a stop.
class TripRecovery {
public:
    static constexpr double kPause_s = 3.0;   ///< from being free to the reset
    static constexpr double kLift_s = 1.5;    ///< the motors wait in contact, until the hand
                                              ///< is lifted
    static constexpr int kMaxResets = 3;      ///< in vain, then a person is needed
    static constexpr double kProven_s = 20.0; ///< of running, and no reset was in vain

    Remedy update(const RecoveryState &now);

    [[nodiscard]] Condition condition() const { return condition_; }
    [[nodiscard]] double goes_on_in_s() const { return goes_on_in_s_; } ///< of `pause`

    /// A person lets it go on.
    void begin_anew() { *this = {}; }

private:
    Remedy recover(const RecoveryState &now);
    Remedy watch(const RecoveryState &now);

    Condition condition_ = Condition::well;
    double goes_on_in_s_ = 0.0;
    std::optional<double> calm_since_s_;   ///< while stopped, and all is free
    std::optional<double> caught_since_s_; ///< while the motors wait in contact
    std::optional<double> running_since_s_;
    int resets_ = 0; ///< since it was proven
};

} // namespace springdrive::app::exhibit

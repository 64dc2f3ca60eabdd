// Covers app/exhibit/healing.cpp, in simulated time.
#include "app/exhibit/healing.h"

#include <gtest/gtest.h>

namespace springdrive::app::exhibit {
namespace {

using servo::SafetyState;
using servo::TripCause;

constexpr double kHealingFrame_s = 0.125; // sums of it are exact

HealingNow stopped_by(TripCause cause) {
    HealingNow now;
    now.state = SafetyState::tripped;
    now.cause = cause;
    return now;
}

class Patient {
public:
    /// The time until the first remedy; `limit_s` if there was none.
    double until_remedy_s(HealingNow now, double limit_s) {
        const double begin_s = time_s_;
        while (time_s_ - begin_s < limit_s - 1e-9) {
            time_s_ += kHealingFrame_s;
            now.time_s = time_s_;
            last = healing.update(now);
            if (last != Remedy::none) {
                return time_s_ - begin_s;
            }
        }
        return limit_s;
    }
    void pass(HealingNow now, double seconds) { EXPECT_EQ(until_remedy_s(now, seconds), seconds); }

    Healing healing;
    Remedy last = Remedy::none;

private:
    double time_s_ = 100.0;
};

TEST(ExhibitHealing, ResetsAfterAPause) {
    Patient patient;
    const HealingNow now = stopped_by(TripCause::tip_speed);
    EXPECT_NEAR(patient.until_remedy_s(now, 20.0), Healing::kPause_s, 1.5 * kHealingFrame_s);
    EXPECT_EQ(patient.last, Remedy::reset);
    EXPECT_NEAR(patient.until_remedy_s(now, 20.0), Healing::kPause_s,
                1.5 * kHealingFrame_s); // in vain
    patient.pass({}, 1.0);
    EXPECT_EQ(patient.healing.condition(), Condition::well);
}

TEST(ExhibitHealing, AStopByAPersonIsKeptForLonger) {
    Patient patient;
    EXPECT_NEAR(patient.until_remedy_s(stopped_by(TripCause::emergency_stop), 20.0),
                Healing::kPauseAfterStop_s, 1.5 * kHealingFrame_s);
    EXPECT_GT(Healing::kPauseAfterStop_s, Healing::kPause_s);
}

TEST(ExhibitHealing, OfARealDeviceAStopByAPersonIsLeftToAPerson) {
    Patient patient;
    HealingNow now = stopped_by(TripCause::emergency_stop);
    now.is_real = true;
    patient.pass(now, 3600.0);
    EXPECT_EQ(patient.healing.condition(), Condition::asks_go_on);
    now.cause = TripCause::tip_speed; // any other is healed there, too
    EXPECT_LT(patient.until_remedy_s(now, 20.0), Healing::kPause_s + 2.0 * kHealingFrame_s);
}

TEST(ExhibitHealing, WaitsUntilTheHandIsLetGoAndTheTipIsFree) {
    Patient patient;
    HealingNow now = stopped_by(TripCause::tip_force);
    now.hand_is_held = true;
    now.is_touching = true;
    patient.pass(now, 60.0);
    EXPECT_EQ(patient.healing.condition(), Condition::let_go);
    now.hand_is_held = false;
    EXPECT_NEAR(patient.until_remedy_s(now, 20.0), kHealingFrame_s, 1e-6);
    EXPECT_EQ(patient.last, Remedy::lift_hand);
    now.is_touching = false;
    patient.pass(now, Healing::kPause_s - 0.5 * kHealingFrame_s);
    EXPECT_EQ(patient.healing.condition(), Condition::pause);
    EXPECT_LT(patient.healing.goes_on_in_s(), 2.0 * kHealingFrame_s);
    EXPECT_LE(patient.until_remedy_s(now, 20.0), 2.0 * kHealingFrame_s);
    EXPECT_EQ(patient.last, Remedy::reset);
}

TEST(ExhibitHealing, WaitsForALostDevice) {
    Patient patient;
    HealingNow now = stopped_by(TripCause::device_lost);
    now.is_lost = true;
    patient.pass(now, 3600.0);
    EXPECT_EQ(patient.healing.condition(), Condition::lost);
    now.is_lost = false;
    EXPECT_NEAR(patient.until_remedy_s(now, 20.0), Healing::kPause_s, 1.5 * kHealingFrame_s);
}

TEST(ExhibitHealing, NeverResetsAFinalCause) {
    Patient patient;
    patient.pass(stopped_by(TripCause::assertion), 3600.0);
    EXPECT_EQ(patient.healing.condition(), Condition::needs_staff);
}

/// A fault that comes back at once: five quick trials, then one a minute, and somebody is asked
/// for.
TEST(ExhibitHealing, AsksForStaffWhenResetsAreInVain) {
    Patient patient;
    const HealingNow now = stopped_by(TripCause::board_fault);
    HealingNow running;
    running.state = SafetyState::running;
    for (int i = 0; i < Healing::kStubborn; ++i) {
        EXPECT_NEAR(patient.until_remedy_s(now, 100.0), Healing::kPause_s, 1.5 * kHealingFrame_s)
            << i;
        patient.pass(running, Healing::kProven_s - 2.0 * kHealingFrame_s);
    }
    EXPECT_NEAR(patient.until_remedy_s(now, 100.0), Healing::kStubbornPause_s,
                1.5 * kHealingFrame_s);
    EXPECT_EQ(patient.healing.condition(), Condition::needs_staff);
    patient.pass(running, Healing::kProven_s + 2.0 * kHealingFrame_s);
    EXPECT_NEAR(patient.until_remedy_s(now, 100.0), Healing::kPause_s, 1.5 * kHealingFrame_s);
}

TEST(ExhibitHealing, PlayingWithTheStopOrTheCableNeedsNoStaff) {
    for (const TripCause cause : {TripCause::emergency_stop, TripCause::device_lost}) {
        Patient patient;
        for (int i = 0; i < 3 * Healing::kStubborn; ++i) {
            EXPECT_LT(patient.until_remedy_s(stopped_by(cause), 100.0),
                      Healing::kPauseAfterStop_s + 2.0 * kHealingFrame_s);
            patient.pass({}, kHealingFrame_s);
        }
    }
}

TEST(ExhibitHealing, LiftsATipThatMotorsWaitForUnlessItIsHeld) {
    Patient patient;
    HealingNow now;
    now.is_touching = true;
    now.hand_is_held = true;
    patient.pass(now, 60.0);
    EXPECT_EQ(patient.healing.condition(), Condition::lift);
    now.hand_is_held = false;
    EXPECT_NEAR(patient.until_remedy_s(now, 20.0), Healing::kLift_s, 1.5 * kHealingFrame_s);
    EXPECT_EQ(patient.last, Remedy::lift_hand);
    now.state = SafetyState::running; // that is what it is there for
    patient.pass(now, 60.0);
    EXPECT_EQ(patient.healing.condition(), Condition::well);
    now.is_inside = true;
    EXPECT_LT(patient.until_remedy_s(now, 20.0), Healing::kLift_s + 2.0 * kHealingFrame_s);
}

TEST(ExhibitHealing, ADeviceWithoutItsZeroNeedsTheStaff) {
    Patient patient;
    HealingNow now;
    now.is_zeroed = false;
    patient.pass(now, 60.0);
    EXPECT_EQ(patient.healing.condition(), Condition::needs_zeroing);
}

} // namespace
} // namespace springdrive::app::exhibit

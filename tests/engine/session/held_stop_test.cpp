// Covers engine/session/servo_run.cpp: a requested stop, by window or switch, and who lets it go.
#include "tests/engine/session/session_fixture.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace springdrive::session {
namespace {

using servo::SafetyState;

SessionOptions at_rest(const std::vector<const char *> &faults = {}) {
    SessionOptions options = testing::emulated(true, faults);
    if (faults.empty()) {
        options.device.kind = factory::DeviceKind::simulated;
    }
    options.servo_hz = 500.0;
    return options;
}

SafetyState state(const Session &session) { return session.latest().safety.state; }

/// Above the plate.
void expect_runs(Session &session) {
    session.hand().move_to({0.0, 0.03, 0.0});
    EXPECT_TRUE(testing::run_until(
        session, [&] { return state(session) == SafetyState::running; }, 8.0))
        << servo::description(session.latest().safety);
}

/// With a reset by a program in every frame.
void expect_stays_stopped(Session &session, double seconds) {
    for (double passed_s = 0.0; passed_s < seconds; passed_s += testing::kFrame_s) {
        session.servo().reset_safety();
        session.advance(testing::kFrame_s);
        ASSERT_EQ(state(session), SafetyState::tripped);
        ASSERT_TRUE(session.servo().is_held_stopped());
        ASSERT_EQ(session.latest().command.e_W_V, Vector3::Zero());
    }
}

void expect_goes_on(Session &session) {
    session.servo().let_go_on();
    EXPECT_FALSE(session.servo().is_held_stopped());
    expect_runs(session);
}

TEST(HeldStop, IsNotLetGoByAnOrderOfItsOwnFrameNorOfTheNext) {
    for (const bool lets_go_first : {false, true}) {
        Session session(at_rest());
        session.start();
        expect_runs(session);
        if (lets_go_first) {
            session.servo().let_go_on();
        }
        session.servo().emergency_stop();
        if (!lets_go_first) {
            session.servo().let_go_on();
        }
        session.advance(testing::kFrame_s);
        EXPECT_EQ(state(session), SafetyState::tripped);
        session.servo().let_go_on(); // as pressed before any frame has shown the stop
        expect_stays_stopped(session, 1.0);
        expect_goes_on(session);
    }
}

TEST(HeldStop, IsNotLetGoByAnOrderThatWasOfAnEarlierOne) {
    Session session(at_rest());
    session.start();
    expect_runs(session);
    session.servo().emergency_stop();
    testing::run(session, 0.1);
    session.servo().let_go_on();
    session.servo().emergency_stop(); // by somebody else, before a tick has seen the order
    expect_stays_stopped(session, 1.0);
    expect_goes_on(session);
}

/// A switch that is pressed and released again while a person lets an earlier stop go.
TEST(HeldStop, OfTheSwitchHoldsAfterItsReleaseAndAgainstAnOrderOfAnEarlierStop) {
    Session session(at_rest({"stop@4-5"}));
    session.start();
    expect_runs(session);
    testing::run_until(
        session, [&] { return session.latest().time_s > 3.5; }, 4.0);
    session.servo().emergency_stop();
    testing::run_until(
        session, [&] { return session.latest().board_faults != 0; }, 1.0);
    ASSERT_EQ(session.latest().safety.cause, servo::TripCause::emergency_stop);
    session.servo().let_go_on(); // of the key's; no frame has shown the switch's
    expect_stays_stopped(session, 4.0);
    expect_goes_on(session);
}

/// As by somebody else, while the board has latched the one before, until after the order.
TEST(HeldStop, OfASecondPressHoldsAgainstAnOrderOfTheFirst) {
    for (const char *const second : {"stop@5-5.01", "stop@5-5.04", "stop@5-5.09"}) {
        Session session(at_rest({"stop@4-4.1", second}));
        session.start();
        expect_runs(session);
        ASSERT_TRUE(testing::run_until(
            session, [&] { return session.latest().safety.held_stop == 2; }, 6.0));
        session.servo().let_go_on();
        expect_stays_stopped(session, 1.0);
        expect_goes_on(session);
    }
}

/// The window has not drawn the second one when it is clicked.
TEST(HeldStop, IsNotLetGoByAnOrderForTheOneThatTheFrameShowed) {
    Session session(at_rest({"stop@4-4.2"}));
    session.start();
    expect_runs(session);
    session.emergency_stop();
    ASSERT_TRUE(testing::run_until(
        session, [&] { return session.latest().time_s > 3.9; }, 4.0));
    while (session.latest().board_faults == 0) { // seen by the servo during the frame
        session.servo().servo().advance(1);
        session.servo().take_in();
    }
    session.advance(testing::kFrame_s);
    session.servo().let_go_on();
    expect_stays_stopped(session, 1.0);
    expect_goes_on(session);
}

/// Whoever lets it go while it is still pressed: nothing moves, and its release starts nothing.
TEST(HeldStop, OfASwitchThatIsStillPressedHoldsAnew) {
    Session session(at_rest({"stop@4-6"}));
    session.start();
    expect_runs(session);
    ASSERT_TRUE(testing::run_until(
        session, [&] { return state(session) == SafetyState::tripped; }, 4.0));
    for (int i = 0; i < 5; ++i) {
        testing::run(session, 0.2);
        session.servo().let_go_on();
    }
    testing::run(session, 0.2);
    ASSERT_LT(session.latest().time_s, 6.0);
    expect_stays_stopped(session, 4.0);
    expect_goes_on(session);
}

TEST(HeldStop, OutlastsAnExchangeOfTheDevice) {
    for (const bool by_switch : {false, true}) {
        Session session(at_rest({by_switch ? "stop@4-4.5" : "stop@1000-1001"}));
        session.start();
        expect_runs(session);
        if (by_switch) {
            ASSERT_TRUE(testing::run_until(
                session, [&] { return state(session) == SafetyState::tripped; }, 4.0));
        } else {
            session.servo().emergency_stop(); // not yet seen by any tick
        }
        session.exchange_device(testing::premium());
        ASSERT_TRUE(testing::run_until(
            session, [&] { return !session.is_exchanging(); }, 2.0));
        testing::run(session, 0.1);
        expect_stays_stopped(session, 1.0);
        expect_goes_on(session);
        session.exchange_device(testing::premium()); // and what was let go does not come back
        ASSERT_TRUE(testing::run_until(
            session, [&] { return !session.is_exchanging(); }, 2.0));
        expect_runs(session);
    }
}

TEST(HeldStop, IsWhatATripBecomesByAnExchangeOfTheDevice) {
    Session session(at_rest({"unplug@4-6"}));
    session.start();
    expect_runs(session);
    ASSERT_TRUE(testing::run_until(
        session, [&] { return state(session) == SafetyState::tripped; }, 4.0));
    session.exchange_device(testing::premium());
    ASSERT_TRUE(testing::run_until(
        session, [&] { return !session.is_exchanging(); }, 2.0));
    testing::run(session, 0.1);
    expect_stays_stopped(session, 1.0);
    expect_goes_on(session);
}

TEST(HeldStop, OutlastsALostCable) {
    Session session(at_rest({"unplug@4-6"}));
    session.start();
    expect_runs(session);
    ASSERT_TRUE(testing::run_until(
        session, [&] { return state(session) == SafetyState::tripped; }, 4.0));
    EXPECT_EQ(session.latest().safety.cause, servo::TripCause::device_lost);
    session.servo().emergency_stop();
    session.advance(testing::kFrame_s);
    expect_stays_stopped(session, 5.0);
    EXPECT_EQ(session.latest().health, device::DeviceHealth::ok);
    EXPECT_NE(servo::description(session.latest().safety).find("stopped by hand"),
              std::string::npos);
    expect_goes_on(session);
}

} // namespace
} // namespace springdrive::session

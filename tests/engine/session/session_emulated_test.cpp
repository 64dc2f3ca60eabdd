// Covers engine/session/session_device.cpp and device/factory/emulated_device.cpp: a session with
// an emulated board in this process, its cable, and the exclusive use of the device; and
// servo_run.cpp: a requested stop, by window or switch, and who lets it go.
#include "base/input_error.h"
#include "device/core/device_file.h"
#include "device/core/phantom/kinematics.h"
#include "device/simulated/hand_tours.h"
#include "engine/commissioning/self_test.h"
#include "engine/session/servo_run.h"
#include "tests/engine/session/session_fixture.h"

#include <gtest/gtest.h>

#include <atomic>
#include <numbers>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace springdrive::session {
namespace {

using servo::SafetyState;
using servo::TripCause;
using testing::emulated;

const Vector3 kOverPlate_m(0.0, 0.03, 0.0);
const Vector3 kInPlate_m(0.0, -0.01, 0.0);

emulator::EmulatedBoard &board_of(Session &session) { return session.device().emulated()->board(); }

bool stands_over_plate(Session &session) {
    session.hand().move_to(kOverPlate_m);
    return testing::run_until(
        session,
        [&] {
            return session.latest().safety.state == SafetyState::running &&
                   (session.latest().tip_m - kOverPlate_m).norm() < 5e-3;
        },
        6.0);
}

bool presses(Session &session) {
    session.hand().move_to(kInPlate_m);
    return testing::run_until(
        session,
        [&] { return session.latest().contact.touching && session.latest().tip_force_N.y() > 0.3; },
        4.0);
}

void set_plugged(Session &session, bool is_plugged) {
    session.servo().paused([&] { session.device().emulated()->set_plugged(is_plugged); });
}

TEST(EmulatedSession, StartsInItsZeroPoseAndDrivesNothingUntilItIsZeroed) {
    Session session(emulated(false));
    session.start();
    EXPECT_EQ(session.device().identity().kind, "emulated");
    EXPECT_FALSE(session.is_zeroed());
    EXPECT_NE(session.warnings().all().at(0).find("until the device has been zeroed"),
              std::string::npos);
    for (int i = 0; i < 400; ++i) {
        session.advance(4e-3);
        ASSERT_NE(board_of(session).board().loop().state(), usb::BoardState::driving);
        ASSERT_EQ(session.latest().safety.state, SafetyState::waiting);
    }
    session.zero_device(Vector3::Zero());
    ASSERT_TRUE(stands_over_plate(session));
    EXPECT_EQ(board_of(session).board().loop().state(), usb::BoardState::driving);
    // It was zeroed as the hand held it, less than a millimetre below the zero pose by its weight.
    constexpr double kSag_m = 1e-3;
    EXPECT_LT((session.latest().tip_m - board_of(session).phantom().truth().tip_m).norm(), kSag_m);
    EXPECT_TRUE(presses(session));
    session.stop();
}

/// Means of the last part of a press that has settled.
struct Pressed {
    double force_N = 0.0;
    double depth_m = 0.0;
    Matrix3 J{Matrix3::Zero()};
};

Pressed settled_press(SessionOptions options) {
    options.effects.coulomb_friction = false; // the rest would depend on the way there
    options.effects.gravity = false;          // the zero pose would be the hand's sagging one
    Session session(options);
    session.start();
    EXPECT_TRUE(stands_over_plate(session));
    EXPECT_TRUE(presses(session));
    testing::run(session, 1.2);
    Pressed mean;
    constexpr int kFrames = 300;
    for (int i = 0; i < kFrames; ++i) {
        session.advance(1e-3);
        EXPECT_TRUE(session.latest().contact.touching);
        mean.force_N += session.latest().tip_force_N.y() / kFrames;
        mean.depth_m += (session.latest().contact.x0_m - session.latest().tip_m).y() / kFrames;
    }
    const device::PhantomGeometry &geometry = session.description().geometry;
    mean.J = device::motor_jacobian(geometry,
                                    device::joint_from_motor(geometry, session.latest().theta_rad));
    session.stop();
    return mean;
}

/// Bound: one count on every motor moves the tip by Σ ‖J_j‖ δ at most, against the stiffness that
/// the press itself shows.
TEST(EmulatedSession, PressesAsTheSimulatedDeviceWithinACount) {
    const Pressed on_board = settled_press(emulated(true));
    SessionOptions simulated = testing::scripted();
    simulated.plays_script = false;
    simulated.delay_periods = 0.3; // of the emulated board
    const Pressed in_process = settled_press(simulated);
    const double stiffness_N_per_m = in_process.force_N / in_process.depth_m;
    const double count_m =
        in_process.J.colwise().norm().sum() * testing::phantom_1_0().rad_per_count();
    EXPECT_GT(in_process.force_N, 0.3);
    EXPECT_NEAR(on_board.force_N, in_process.force_N, stiffness_N_per_m * count_m);
}

TEST(EmulatedSession, ComesBackAfterItsCableWasPulledInContact) {
    Session session(emulated(true));
    session.start();
    ASSERT_TRUE(stands_over_plate(session));
    ASSERT_TRUE(presses(session));
    set_plugged(session, false);
    testing::run(session, 1.0);
    EXPECT_EQ(session.latest().safety.cause, TripCause::device_lost);
    EXPECT_EQ(board_of(session).board().loop().state(), usb::BoardState::fault_braking);
    session.hand().move_to(kOverPlate_m);
    testing::run(session, 1.0); // the hand goes on without the host
    EXPECT_LT((board_of(session).phantom().truth().tip_m - kOverPlate_m).norm(), 5e-3);
    set_plugged(session, true);
    testing::run(session, 1.0);
    EXPECT_EQ(session.latest().health, device::DeviceHealth::ok);
    EXPECT_TRUE(session.is_zeroed()); // the board kept its power, and counted
    EXPECT_LT((session.latest().tip_m - board_of(session).phantom().truth().tip_m).norm(), 1e-3);
    EXPECT_EQ(session.latest().safety.cause, TripCause::device_lost); // until a reset
    EXPECT_NE(board_of(session).board().loop().state(), usb::BoardState::driving);
    session.servo().reset_safety();
    ASSERT_TRUE(stands_over_plate(session));
    EXPECT_TRUE(presses(session));
    session.stop();
}

TEST(EmulatedSession, FollowsItsScriptFromTheZeroPose) {
    SessionOptions options = emulated(true);
    options.plays_script = true;
    Session session(options);
    session.start();
    EXPECT_TRUE(testing::run_into_contact(session));
    session.stop();
}

TEST(LentDevice, IsUsedByNobodyElseAndIsReleasedBefore) {
    Session session(emulated(true));
    session.start();
    ASSERT_TRUE(stands_over_plate(session));
    int ticks = 0;
    bool was_driven = false;
    session.begin_exclusive_use([&] {
        device::HapticDevice &device = session.device().device();
        static_cast<void>(device.read());
        was_driven =
            was_driven || board_of(session).board().loop().state() == usb::BoardState::driving;
        device.write(device::DeviceCommand::braking());
        return ++ticks < 500;
    });
    EXPECT_TRUE(session.is_in_exclusive_use());
    ASSERT_TRUE(testing::run_until(
        session, [&] { return ticks > 100; }, 3.0));
    const std::uint64_t tick = session.latest().tick;
    testing::run(session, 0.1);
    EXPECT_EQ(session.latest().tick, tick);
    EXPECT_NE(error_text_of([&] { session.zero_device(Vector3::Zero()); }), "");
    EXPECT_NE(error_text_of([&] { session.set_servo_rate(2000.0); }), "");
    EXPECT_NE(error_text_of([&] { session.reconnect_device(); }), "");
    EXPECT_NE(error_text_of([&] { session.exchange_device(session.device_choice()); }), "");
    EXPECT_NE(error_text_of([&] { session.begin_exclusive_use([] { return false; }); }), "");
    testing::run(session, 1.0);
    EXPECT_FALSE(session.is_in_exclusive_use());
    EXPECT_EQ(session.exclusive_use_error(), "");
    EXPECT_EQ(ticks, 500);
    EXPECT_FALSE(was_driven);
    EXPECT_GT(session.latest().tick, tick);
    EXPECT_TRUE(stands_over_plate(session)); // no trip by the gap
    EXPECT_TRUE(presses(session));
    session.stop();
}

TEST(LentDevice, ComesBackAtAnEmergencyStopAndStaysStopped) {
    Session session(emulated(true));
    session.start();
    ASSERT_TRUE(stands_over_plate(session));
    int ticks = 0;
    session.begin_exclusive_use([&] {
        static_cast<void>(session.device().device().read());
        session.device().device().write(device::DeviceCommand::braking());
        return ++ticks > 0;
    });
    ASSERT_TRUE(testing::run_until(
        session, [&] { return ticks > 10; }, 3.0));
    session.servo().emergency_stop();
    testing::run(session, 0.1);
    EXPECT_FALSE(session.is_in_exclusive_use());
    EXPECT_EQ(session.latest().safety.cause, TripCause::emergency_stop);
    EXPECT_NE(error_text_of([&] { session.begin_exclusive_use([] { return false; }); }), "");
    session.stop();
}

/// Test pulses go on at a board whose host brakes, for half a second; commands may be lost.
TEST(LentDevice, AStopEndsItAndItsPulsesAtOnce) {
    for (const double loses_s : {0.0, 1e-3, 1.7e-3, 4e-3}) {
        Session session(emulated(true));
        session.start();
        ASSERT_TRUE(stands_over_plate(session));
        std::optional<commissioning::SelfTest> test;
        session.begin_exclusive_use([&] {
            if (!test) {
                test.emplace(session.device().device());
            }
            return test->step();
        });
        emulator::EmulatedBoard &board = board_of(session);
        const auto largest_A = [&] {
            return board.phantom().truth().current_A.cwiseAbs().maxCoeff();
        };
        ASSERT_TRUE(testing::run_until(
            session, [&] { return largest_A() > 0.2; }, 3.0));
        if (loses_s > 0.0) {
            device::Fault loss = device::parse_fault("drop:out");
            loss.begin_s = board.time_s();
            loss.end_s = loss.begin_s + loses_s;
            board.set_fault(loss);
        }
        session.emergency_stop(); // between two frames
        EXPECT_FALSE(session.is_in_exclusive_use());
        EXPECT_NE(board.board().loop().state(), usb::BoardState::testing);
        for (int i = 0; i < 600; ++i) {
            session.advance(1e-3);
            EXPECT_LT(largest_A(), i < 4 ? 0.4 : 0.02); // L/R is 0.7 ms
        }
        EXPECT_EQ(session.latest().safety.cause, TripCause::emergency_stop);
        session.stop();
    }
}

TEST(LentDevice, GivesTheReasonIfItsUserFails) {
    Session session(emulated(true));
    session.start();
    session.begin_exclusive_use([]() -> bool { throw InputError("it burns"); });
    testing::run(session, 3.0);
    EXPECT_FALSE(session.is_in_exclusive_use());
    EXPECT_EQ(session.exclusive_use_error(), "it burns");
    session.stop();
}

TEST(LentDevice, PassesASelfTestInTheSimulatedHand) {
    Session session(emulated(true));
    session.start();
    testing::run(session, 0.1);
    commissioning::SelfTest test(
        session.device().device(), {},
        simulated::stop_tour_of(session.device().hand(), session.description()));
    session.begin_exclusive_use([&] { return test.step(); });
    ASSERT_TRUE(testing::run_until(
        session, [&] { return !session.is_in_exclusive_use(); }, 60.0));
    EXPECT_EQ(session.exclusive_use_error(), "");
    EXPECT_TRUE(test.report().has_passed());
    EXPECT_TRUE(stands_over_plate(session));
    session.stop();
}

/// Of an emulated device, with possible numbers.
device::Calibration calibration_of(const std::string &serial) {
    device::Calibration calibration;
    calibration.serial = serial;
    calibration.kind = "USB";
    calibration.made_at_s = 1'764'000'000;
    for (std::size_t j = 0; j < 3; ++j) {
        for (const device::CalibrationField &field :
             device::calibration_fields(testing::phantom_1_0(), j, 10.0)) {
            calibration.motor[j].*field.value =
                0.4 * field.range.minimum + 0.6 * field.range.maximum;
        }
    }
    return calibration;
}

TEST(CalibratedSession, GoesOnWithANewCalibrationInAFileOfItsOwn) {
    const std::filesystem::path folder = testing::fresh_folder("calibrated_session");
    Session session(emulated(true));
    session.start();
    session.keep_released(true);
    session.start_recording(folder / "touch.rec");
    testing::run(session, 0.3);
    const std::string before = session.past().back().header.device_toml;
    session.use_calibration(calibration_of(factory::kEmulatedSerial));
    testing::run(session, 0.3);
    ASSERT_TRUE(session.description().calibration);
    const double R_Ohm = session.description().calibration->motor[0].resistance_Ohm;
    // Observers start from it, and learn little at rest.
    const double file_Ohm = testing::phantom_1_0().motor[0].resistance_Ohm;
    EXPECT_NEAR(session.latest().motor[0].mean.resistance_Ohm, R_Ohm,
                0.1 * std::abs(R_Ohm - file_Ohm));
    EXPECT_EQ(session.latest().safety.state, SafetyState::waiting); // still kept released
    EXPECT_TRUE(session.is_zeroed());
    EXPECT_EQ(session.recording().parts().size(), 2U);
    ASSERT_EQ(session.past().size(), 2U);
    EXPECT_EQ(session.past().front().header.device_toml, before);
    EXPECT_NE(session.past().back().header.device_toml.find("[calibration]"), std::string::npos);
    session.keep_released(false);
    EXPECT_TRUE(stands_over_plate(session));
    EXPECT_TRUE(presses(session));
    session.stop();
}

TEST(CalibratedSession, IsRefusedWhileDrivenOrStoppedAndForAnotherDevice) {
    Session session(emulated(true));
    session.start();
    ASSERT_TRUE(stands_over_plate(session));
    const auto refused = [&](const device::Calibration &calibration) {
        const std::string error = error_text_of([&] { session.use_calibration(calibration); });
        EXPECT_FALSE(session.description().calibration);
        return error;
    };
    const device::Calibration own = calibration_of(factory::kEmulatedSerial);
    EXPECT_NE(refused(own).find("a motor is driven"), std::string::npos);
    session.keep_released(true);
    testing::run(session, 1.0);
    EXPECT_NE(refused(calibration_of("another")).find("another"), std::string::npos);
    device::Calibration impossible = own;
    impossible.motor[1].resistance_Ohm *= 2.0;
    EXPECT_NE(refused(impossible).find("resistance_Ohm"), std::string::npos);
    session.servo().emergency_stop();
    testing::run(session, 0.1);
    EXPECT_NE(refused(own).find("emergency stop"), std::string::npos);
    EXPECT_EQ(session.latest().safety.cause, TripCause::emergency_stop);
    session.servo().let_go_on();
    testing::run(session, 0.1);
    EXPECT_EQ(error_text_of([&] { session.use_calibration(own); }), "");
    session.stop();
    Session simulated(testing::scripted());
    EXPECT_NE(error_text_of([&] { simulated.use_calibration(own); }), ""); // has no board
}

/// The cable is noticed on a servo whose time began anew, too.
TEST(CalibratedSession, IsConnectedAgainAfterwards) {
    Session session(emulated(true));
    session.start();
    session.keep_released(true);
    testing::run(session, 5.0);
    session.use_calibration(calibration_of(factory::kEmulatedSerial));
    testing::run(session, 0.3);
    set_plugged(session, false);
    testing::run(session, 0.5);
    EXPECT_EQ(session.latest().health, device::DeviceHealth::lost);
    set_plugged(session, true);
    testing::run(session, 1.2); // a look each half a second
    EXPECT_EQ(session.latest().health, device::DeviceHealth::ok);
    EXPECT_TRUE(session.description().calibration);
    session.stop();
}

/// With the servo and the exclusive use on threads of their own.
TEST(LentDevice, IsUsedOnAThreadAndComesBack) {
    SessionOptions options = emulated(true);
    options.lockstep = false;
    Session session(options);
    session.start();
    std::atomic<int> ticks{0};
    std::thread::id user;
    session.begin_exclusive_use([&] {
        user = std::this_thread::get_id();
        static_cast<void>(session.device().device().read());
        session.device().device().write(device::DeviceCommand::braking());
        return ++ticks < 50;
    });
    ASSERT_TRUE(testing::run_until(
        session, [&] { return !session.is_in_exclusive_use(); }, 20.0));
    EXPECT_EQ(ticks, 50);
    EXPECT_NE(user, std::this_thread::get_id());
    const std::uint64_t tick = session.latest().tick;
    EXPECT_TRUE(testing::run_until(
        session, [&] { return session.latest().tick > tick + 20; }, 20.0));
    EXPECT_NE(session.latest().safety.state, SafetyState::tripped);
    session.stop();
}

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
    EXPECT_TRUE(testing::run_until_state(session, servo::SafetyState::running, 8.0))
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
    ASSERT_TRUE(testing::run_until_state(session, servo::SafetyState::tripped, 4.0));
    for (int i = 0; i < 5; ++i) {
        testing::run(session, 0.2);
        session.servo().let_go_on();
    }
    testing::run(session, 0.2);
    ASSERT_LT(session.latest().time_s, 6.0);
    expect_stays_stopped(session, 4.0);
    expect_goes_on(session);
}

/// A stop by a key that no tick has seen yet, one by the switch, and what any trip becomes.
TEST(HeldStop, OutlastsAnExchangeOfTheDevice) {
    struct Case {
        const char *fault;
        bool is_by_key;
    };
    for (const Case &one :
         {Case{"stop@1000-1001", true}, Case{"stop@4-4.5", false}, Case{"unplug@4-6", false}}) {
        SCOPED_TRACE(one.fault);
        Session session(at_rest({one.fault}));
        session.start();
        expect_runs(session);
        if (one.is_by_key) {
            session.servo().emergency_stop();
        } else {
            ASSERT_TRUE(testing::run_until_state(session, SafetyState::tripped, 4.0));
        }
        session.exchange_device(testing::premium());
        ASSERT_TRUE(testing::run_until_exchanged(session, 2.0));
        testing::run(session, 0.1);
        expect_stays_stopped(session, 1.0);
        expect_goes_on(session);
        session.exchange_device(testing::premium()); // and what was let go does not come back
        ASSERT_TRUE(testing::run_until_exchanged(session, 2.0));
        expect_runs(session);
    }
}

TEST(HeldStop, OutlastsALostCable) {
    Session session(at_rest({"unplug@4-6"}));
    session.start();
    expect_runs(session);
    ASSERT_TRUE(testing::run_until_state(session, servo::SafetyState::tripped, 4.0));
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

// Covers engine/session/session_link.cpp: a session with a board on USB, in process.
#include "base/error_text.h"
#include "device/core/phantom/kinematics.h"
#include "device/usb/driver/usb_device.h"
#include "tests/engine/session/session_fixture.h"
#include "tests/support/emulated_port.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::session {
namespace {

using servo::SafetyState;
using servo::TripCause;

const Vector3 kAbovePlate_m(0.0, 0.03, 0.0);
const Vector3 kIntoPlate_m(0.0, -0.01, 0.0);

/// In place of the device that the session opened.
class UsbSession {
public:
    explicit UsbSession(bool starts_at_zero = false)
        : board(testing::phantom_1_0(), board_options()), session(options(starts_at_zero)) {
        port = new testing::EmulatedPort(board);
        auto device = std::make_unique<usb::UsbDevice>(std::unique_ptr<usb::BoardPort>(port),
                                                       testing::phantom_1_0(), "", 1e-3,
                                                       usb::Pacing::reports);
        device::HapticDevice &on_usb = *device;
        session.hand().take_hold(nullptr, session.description(), std::nullopt, kAbovePlate_m);
        replaced = std::exchange(session.device(), factory::OpenDevice(std::move(device), nullptr));
        session.servo().renew(on_usb);
        session.start();
    }
    ~UsbSession() { session.stop(); }
    UsbSession(const UsbSession &) = delete;
    UsbSession &operator=(const UsbSession &) = delete;

    static emulator::EmulatedBoardOptions board_options() {
        emulator::EmulatedBoardOptions options;
        options.start_tip_m = Vector3::Zero(); // the zero pose
        return options;
    }
    static SessionOptions options(bool starts_at_zero) {
        SessionOptions options = testing::scripted();
        options.plays_script = false;
        options.starts_at_zero = starts_at_zero;
        return options;
    }

    [[nodiscard]] bool run_until_state(SafetyState state, double at_most_s = 6.0) {
        return testing::run_until(
            session, [&] { return session.latest().safety.state == state; }, at_most_s);
    }
    [[nodiscard]] bool press() {
        board.phantom().set_hand_target(kIntoPlate_m);
        return testing::run_until(
            session,
            [&] {
                return session.latest().contact.touching && session.latest().tip_force_N.y() > 0.3;
            },
            4.0);
    }
    [[nodiscard]] bool drives() const {
        return board.board().loop().state() == usb::BoardState::driving;
    }

    emulator::EmulatedBoard board;
    testing::EmulatedPort *port = nullptr;
    Session session;
    std::optional<factory::OpenDevice> replaced;
};

TEST(SessionOnUsb, DrivesNoMotorUntilItIsZeroed) {
    UsbSession usb;
    EXPECT_FALSE(usb.session.is_zeroed());
    for (int i = 0; i < 1000; ++i) {
        usb.session.advance(4e-3);
        ASSERT_FALSE(usb.drives());
        ASSERT_EQ(usb.session.latest().safety.state, SafetyState::waiting);
    }
    usb.session.zero_device(Vector3::Zero());
    EXPECT_TRUE(usb.session.is_zeroed());
    usb.board.phantom().set_hand_target(kAbovePlate_m);
    EXPECT_TRUE(usb.run_until_state(SafetyState::running));
    EXPECT_TRUE(usb.drives());
    EXPECT_LT((usb.session.latest().tip_m - usb.board.phantom().truth().tip_m).norm(), 1e-3);
    EXPECT_TRUE(usb.press());
}

TEST(SessionOnUsb, ComesBackAfterAnUnplugInContact) {
    UsbSession usb(true);
    EXPECT_TRUE(usb.session.is_zeroed());
    usb.board.phantom().set_hand_target(kAbovePlate_m);
    ASSERT_TRUE(usb.run_until_state(SafetyState::running));
    ASSERT_TRUE(usb.press());
    usb.port->unplug();
    usb.port->pass(0.01);
    EXPECT_EQ(usb.board.board().loop().state(), usb::BoardState::fault_braking);
    testing::run(usb.session, 1.0); // it looks for the board, and goes on
    EXPECT_EQ(usb.session.latest().safety.cause, TripCause::device_lost);
    EXPECT_EQ(usb.session.latest().health, device::DeviceHealth::lost);
    usb.board.phantom().set_hand_target(kAbovePlate_m);
    usb.port->pass(1.0);
    usb.port->is_plugged = true;
    testing::run(usb.session, 1.0);
    EXPECT_EQ(usb.session.latest().health, device::DeviceHealth::ok);
    EXPECT_TRUE(usb.session.is_zeroed()); // the board kept its power
    EXPECT_EQ(usb.session.latest().safety.cause, TripCause::device_lost); // until a reset
    EXPECT_FALSE(usb.drives());
    EXPECT_LT((usb.session.latest().tip_m - usb.board.phantom().truth().tip_m).norm(), 1e-3);
    usb.session.servo().reset_safety();
    EXPECT_TRUE(usb.run_until_state(SafetyState::running));
    EXPECT_TRUE(usb.press());
}

TEST(SessionOnUsb, SaysEachTimeThatItIsConnectedAgain) {
    UsbSession usb(true);
    for (int time = 1; time <= 3; ++time) {
        usb.port->unplug();
        usb.port->pass(0.01);
        testing::run(usb.session, 0.6);
        ASSERT_EQ(usb.session.latest().health, device::DeviceHealth::lost);
        static_cast<void>(usb.session.warnings().take_new());
        usb.port->is_plugged = true;
        testing::run(usb.session, 0.6);
        const std::vector<std::string> said = usb.session.warnings().take_new();
        EXPECT_EQ(said.size(), 1U) << time;
        EXPECT_TRUE(!said.empty() && said[0].find("connected again") != std::string::npos);
    }
}

TEST(SessionOnUsb, DoesNotTakeItsOwnBoardForAnotherProgram) {
    UsbSession usb;
    const DeviceChoice own{usb.session.device_choice().file, factory::DeviceKind::usb,
                           usb.session.device().identity().serial};
    const std::string error = error_text_of([&] { usb.session.exchange_device(own); });
    EXPECT_NE(error.find("in use already"), std::string::npos) << error;
    EXPECT_FALSE(usb.session.is_exchanging());
    EXPECT_EQ(usb.session.device().state(), factory::DeviceState::open);
}

TEST(SessionOnUsb, ABoardThatLostItsPowerMustBeZeroedAgain) {
    UsbSession usb(true);
    usb.board.phantom().set_hand_target(kAbovePlate_m);
    ASSERT_TRUE(usb.run_until_state(SafetyState::running));
    device::Fault restart = device::parse_fault("restart");
    restart.begin_s = usb.board.time_s();
    usb.board.set_fault(restart);
    testing::run(usb.session, 2.0);
    EXPECT_EQ(usb.session.latest().safety.cause, TripCause::device_lost);
    EXPECT_FALSE(usb.session.is_zeroed());
    usb.session.servo().reset_safety();
    for (int i = 0; i < 500; ++i) {
        usb.session.advance(4e-3);
        ASSERT_FALSE(usb.drives());
    }
    usb.session.zero_device(
        device::motor_from_joint(usb.session.description().geometry,
                                 device::joint_angles_rad(usb.session.description().geometry,
                                                          usb.board.phantom().truth().tip_m)
                                     .value()));
    EXPECT_TRUE(usb.run_until_state(SafetyState::running));
}

TEST(SessionOnUsb, SaysThatItMustBeZeroed) {
    UsbSession usb;
    bool says = false;
    for (const std::string &warning : usb.session.warnings().all()) {
        says = says || warning.find("zeroed") != std::string::npos;
    }
    EXPECT_TRUE(says);
}

} // namespace
} // namespace springdrive::session

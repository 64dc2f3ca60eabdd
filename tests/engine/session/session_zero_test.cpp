// Covers the zero of a device's counts in engine/session/session_device.cpp: what voids it, and
// that no motor is driven until somebody zeroes the device again.
#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/lab/rig/faulty_device.h"
#include "tests/engine/session/session_fixture.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace springdrive::session {
namespace {

using servo::SafetyState;
using servo::TripCause;

const Vector3 kFreeStart_m(0.0, 0.03, 0.0);

bool says(const Session &session, const std::string &part) {
    return std::ranges::any_of(session.warnings().all(), [&](const std::string &warning) {
        return warning.find(part) != std::string::npos;
    });
}

/// Of an emulated board, whose truth is that of its plant.
class EmulatedSession {
public:
    explicit EmulatedSession(const char *fault) : session(testing::emulated(true, {fault})) {
        session.start();
    }
    ~EmulatedSession() { session.stop(); }
    EmulatedSession(const EmulatedSession &) = delete;
    EmulatedSession &operator=(const EmulatedSession &) = delete;

    [[nodiscard]] emulator::EmulatedBoard &board() { return session.device().emulated()->board(); }
    [[nodiscard]] bool drives() {
        return board().board().loop().state() == usb::BoardState::driving;
    }
    [[nodiscard]] const simulated::SimulatedPhantom::Truth &truth() {
        return board().phantom().truth();
    }
    [[nodiscard]] bool run_until_state(SafetyState state) {
        return testing::run_until(
            session, [&] { return session.latest().safety.state == state; }, 6.0);
    }
    /// In frames of one tick.
    void expect_no_motor_until(double time_s) {
        while (session.latest().time_s < time_s) {
            session.advance(1e-3);
            ASSERT_FALSE(drives());
            ASSERT_FALSE(servo::lets_pass(session.latest().safety.state));
        }
    }

    Session session;
};

TEST(SessionZero, ABaseThatIsFarOffDrivesNoMotorAfterAReset) {
    constexpr double kFault_s = 1.8;
    constexpr double kRepaired_s = 3.6;
    EmulatedSession test("reversed-encoder:1@1.8-3.6");
    Session &session = test.session;
    const device::PhantomGeometry &geometry = session.description().geometry;
    const double base_rad = 26.45 * kRadiansPerDegree;
    session.hand().move_to(device::tip_position_m(geometry, Vector3(base_rad, 0.2, 0.2)));
    ASSERT_TRUE(test.run_until_state(SafetyState::running));
    ASSERT_LT(session.latest().time_s, kFault_s);
    ASSERT_TRUE(test.drives());
    ASSERT_TRUE(test.run_until_state(SafetyState::tripped));
    const servo::ServoSample tripped = session.latest();
    EXPECT_EQ(tripped.safety.cause, TripCause::board_fault);
    const Vector3 error_rad =
        device::joint_from_motor(geometry, test.truth().theta_rad - tripped.theta_rad);
    EXPECT_NEAR(error_rad[0] * kDegreesPerRadian, 52.9, 1.0);
    session.advance(1e-3);
    EXPECT_FALSE(test.drives());
    EXPECT_FALSE(session.is_zeroed());
    EXPECT_TRUE(says(session, "its zero is void"));

    session.servo().reset_safety();
    test.expect_no_motor_until(2.4);
    session.set_servo_rate(500.0);
    session.reconnect_device();
    EXPECT_FALSE(session.is_zeroed());
    session.servo().reset_safety();
    session.hand().move_to(Vector3::Zero()); // by hand, to its zero pose
    test.expect_no_motor_until(kRepaired_s + 0.2);

    session.zero_device(test.truth().theta_rad);
    EXPECT_TRUE(session.is_zeroed());
    session.hand().move_to(kFreeStart_m);
    session.servo().reset_safety();
    ASSERT_TRUE(test.run_until_state(SafetyState::running));
    EXPECT_TRUE(test.drives());
    testing::run(session, 0.3);
    EXPECT_LT((session.latest().tip_m - test.truth().tip_m).norm(), 1e-3);
    EXPECT_GT(test.truth().tip_m.y(), 0.02);
}

/// Quicker than any report could be missed.
TEST(SessionZero, ABoardThatRestartedDrivesNoMotor) {
    EmulatedSession test("restart@1.8-1.9");
    Session &session = test.session;
    session.hand().move_to(kFreeStart_m);
    ASSERT_TRUE(test.run_until_state(SafetyState::running));
    ASSERT_TRUE(test.run_until_state(SafetyState::tripped));
    EXPECT_EQ(test.board().restarts(), 1U);
    EXPECT_FALSE(session.is_zeroed()); // not only once it is connected again
    while (session.latest().time_s < 3.5) {
        session.servo().reset_safety(); // as what resets by itself does
        session.advance(1e-3);
        ASSERT_FALSE(test.drives());
    }
    EXPECT_EQ(session.latest().health, device::DeviceHealth::ok);
    EXPECT_TRUE(says(session, "lost its counts; zero it"));
    session.zero_device(test.truth().theta_rad);
    EXPECT_TRUE(test.run_until_state(SafetyState::running));
    EXPECT_LT((session.latest().tip_m - test.truth().tip_m).norm(), 1e-3);
}

/// What makes the counts of a device wrong, by the tick in which it is seen.
struct Cause {
    const char *name;
    device::Fault fault;
    TripCause trip;
};

const Cause kCauses[]{
    {"BoardFault",
     {device::FaultKind::board, Vector3(device::BoardFaults::kEncoder, 0.0, 0.0), 0.0, 20.0},
     TripCause::board_fault},
    {"Jump", {device::FaultKind::count_step, Vector3(6000.0, 0.0, 0.0)}, TripCause::encoder_jump},
    {"Stops", {device::FaultKind::count_drift, Vector3(2.0, 0.0, 0.0)}, TripCause::beyond_stops},
    {"OtherStops",
     {device::FaultKind::count_drift, Vector3(-2.0, 0.0, 0.0)},
     TripCause::beyond_stops}};

class ZeroVoidedBy : public ::testing::TestWithParam<Cause> {
protected:
    /// Near the stop towards which the counts run away, if they do.
    static Vector3 start_m() {
        const device::DeviceDescription device = testing::phantom_1_0();
        const device::JointLimits &stops = device.joint_limits;
        const double way = GetParam().fault.kind == device::FaultKind::count_drift
                               ? GetParam().fault.size[0]
                               : 0.0;
        const double base_rad = way > 0.0   ? stops.max_rad[0] - 0.1
                                : way < 0.0 ? stops.min_rad[0] + 0.1
                                            : 0.0;
        return device::tip_position_m(device.geometry, Vector3(base_rad, 0.2, 0.2));
    }
};

TEST_P(ZeroVoidedBy, StaysSoUntilSomebodyZeroesTheDevice) {
    SessionOptions options = testing::scripted();
    options.plays_script = false;
    Session session(options);
    auto phantom = std::make_unique<simulated::SimulatedPhantom>(
        testing::phantom_1_0(), simulated::SimulationOptions{}, start_m());
    simulated::SimulatedPhantom &plant = *phantom;
    auto owned = std::make_unique<rig::FaultyDevice>(std::move(phantom));
    rig::FaultyDevice &device = *owned;
    const factory::OpenDevice replaced =
        std::exchange(session.device(), factory::OpenDevice(std::move(owned), &plant));
    session.servo().renew(device);
    session.hand().take_hold(&plant, session.description(), std::nullopt, start_m());
    session.start();
    const auto state_is = [&](SafetyState state) {
        return [&session, state] { return session.latest().safety.state == state; };
    };
    ASSERT_TRUE(testing::run_until(session, state_is(SafetyState::running), 3.0));
    device.commit(GetParam().fault);
    for (int tick = 0; tick < 3000 && !state_is(SafetyState::tripped)(); ++tick) {
        session.advance(1e-3);
    }
    EXPECT_EQ(session.latest().safety.cause, GetParam().trip);
    EXPECT_FALSE(session.is_zeroed());
    EXPECT_TRUE(says(session, "its zero is void"));
    const auto expect_braking = [&](double seconds) { // in frames of up to two ticks
        for (int frame = 0; frame < static_cast<int>(seconds / 1e-3); ++frame) {
            session.servo().reset_safety(); // as what resets by itself does
            session.advance(1e-3);
            ASSERT_EQ(device.last_command().mode, device::CommandMode::brake);
            ASSERT_NE(session.latest().safety.state, SafetyState::starting);
        }
        EXPECT_FALSE(session.is_zeroed());
    };
    expect_braking(1.5);
    session.set_servo_rate(2000.0);
    expect_braking(0.5);
    session.reconnect_device();
    expect_braking(0.5);
    device.clear_fault();
    session.zero_device(plant.truth().theta_rad);
    EXPECT_TRUE(session.is_zeroed());
    session.servo().reset_safety();
    ASSERT_TRUE(testing::run_until(session, state_is(SafetyState::running), 3.0))
        << servo::description(session.latest().safety);
    EXPECT_LT((session.latest().tip_m - plant.truth().tip_m).norm(), 1e-3);
    session.stop();
}

INSTANTIATE_TEST_SUITE_P(Session, ZeroVoidedBy, ::testing::ValuesIn(kCauses),
                         [](const auto &each) { return each.param.name; });

TEST(SessionZero, ASoundSimulationKnowsItsAngles) {
    simulated::SimulatedPhantom phantom(testing::phantom_1_0(), {}, kFreeStart_m);
    device::DeviceCommand command = device::DeviceCommand::braking();
    command.voids_zero = true;
    phantom.write(command);
    EXPECT_NE(phantom.read().zeroing, 0);
    EXPECT_TRUE(phantom.is_zeroed());
}

} // namespace
} // namespace springdrive::session

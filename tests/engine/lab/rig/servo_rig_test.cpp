// Covers engine/lab/rig/servo_rig.cpp, faulty_device.cpp and
// limits/method_limits/pressed_corner.cpp.
#include "engine/lab/rig/servo_rig.h"

#include "engine/lab/limits/method_limits/pressed_corner.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

namespace springdrive::rig {
namespace {

loops::StabilityCase held_by_a_hand() {
    loops::StabilityCase which;
    which.device = testing::phantom_1_0();
    which.hands = {loops::hand_of_firmness(0.5)};
    return which;
}

TEST(FaultyDevice, IsTheOneBehindItUntilItFails) {
    const device::DeviceDescription description = testing::phantom_1_0();
    const Vector3 start_m(0.0, 0.02, 0.0);
    simulated::SimulatedPhantom truth(description, {}, start_m);
    simulated::SimulatedPhantom behind(description, {}, start_m);
    FaultyDevice device(behind);
    device::DeviceCommand command;
    command.e_W_V = Vector3(0.3, -0.2, 0.1);
    device::Measurement answer;
    for (int i = 0; i < 50; ++i) {
        const device::Measurement expected = truth.advance(command);
        device.write(command);
        answer = device.read();
        EXPECT_EQ(answer.counts, expected.counts);
        EXPECT_EQ(answer.current_A, expected.current_A);
        EXPECT_EQ(answer.number, expected.number);
        EXPECT_EQ(answer.health, device::DeviceHealth::ok);
    }
    device.pass_by(1); // as if the same had been said again
    static_cast<void>(truth.advance(command));
    EXPECT_EQ(behind.truth().tip_m, truth.truth().tip_m);
    device.commit({.kind = device::FaultKind::unplug, .end_s = 2.0});
    for (const device::DeviceHealth health :
         {device::DeviceHealth::lost, device::DeviceHealth::lost, device::DeviceHealth::ok}) {
        const device::Measurement last = answer;
        device.write(device::DeviceCommand::braking());
        answer = device.read();
        EXPECT_EQ(answer.health, health);
        EXPECT_EQ(answer.counts == last.counts, health == device::DeviceHealth::lost);
        EXPECT_TRUE(device.last_command().e_W_V.isZero(0.0));
    }
    device.commit({.kind = device::FaultKind::drop, .end_s = 1.0});
    const device::Measurement last = answer;
    answer = device.read();
    EXPECT_EQ(answer.arrival, device::Arrival::absent);
    EXPECT_EQ(answer.health, device::DeviceHealth::ok);
    EXPECT_EQ(answer.counts, last.counts);
    EXPECT_EQ(device.read().number, last.number + 2);
}

TEST(FaultyDevice, PassesOnWhatItsOwnFaultsMakeOfACommand) {
    const Vector3 start_m(0.0, 0.02, 0.0);
    simulated::SimulatedPhantom truth(testing::phantom_1_0(), {}, start_m);
    simulated::SimulatedPhantom behind(testing::phantom_1_0(), {}, start_m);
    FaultyDevice device(behind);
    device.commit({device::FaultKind::amplifier_gain, Vector3(-1.0, 1.0, 2.0)});
    device::DeviceCommand command;
    command.e_W_V = Vector3(0.3, -0.2, 0.1);
    device::DeviceCommand wrong = command;
    wrong.e_W_V = Vector3(-0.3, -0.2, 0.2);
    for (int i = 0; i < 50; ++i) {
        device.write(command);
        EXPECT_EQ(device.read().counts, truth.advance(wrong).counts);
    }
    EXPECT_EQ(device.last_command().e_W_V, command.e_W_V);
}

TEST(ServoRig, StaysWhereItIsWhenTheHandLetsGo) {
    limits::PressedCorner rig(held_by_a_hand());
    rig.press(2.0);
    const simulated::SimulatedPhantom::Truth before = rig.truth();
    const std::uint64_t number = rig.measured().number;
    rig.let_go();
    EXPECT_LT((rig.truth().theta_rad - before.theta_rad).norm(), 1e-12);
    EXPECT_EQ(rig.truth().current_A, before.current_A);
    rig.tick();
    EXPECT_TRUE(rig.truth().hand_force_N.isZero(0.0));
    EXPECT_EQ(rig.measured().number, number + 1);
    EXPECT_FALSE(rig.has_tripped());
}

TEST(PressedCorner, HoldsTheTipWhereForcesBalance) {
    limits::PressedCorner rig(held_by_a_hand());
    EXPECT_FALSE(rig.last.contact.touching);
    EXPECT_EQ(rig.last.safety.state, servo::SafetyState::running);
    rig.press(2.0);
    EXPECT_EQ(rig.last.contact.active_constraints, 3);
    // At rest, without weight and friction, the hand holds what the motors render.
    EXPECT_LT((rig.last.tip_force_N + rig.truth().hand_force_N).norm(), 1e-3);
    EXPECT_GT(rig.last.tip_force_N.norm(), 1.0);
    const Vector3 before_m = rig.last.tip_m;
    rig.nudge();
    rig.run(0.5);
    EXPECT_GT((rig.last.tip_m - before_m).norm(), 1e-6);
    EXPECT_FALSE(rig.has_tripped());
}

TEST(ServoRig, TellsTheServoOfMissedDeadlines) {
    limits::PressedCorner rig(held_by_a_hand());
    EXPECT_EQ(rig.late_tick(3).missed_periods, 3U);
    EXPECT_DOUBLE_EQ(rig.late_tick(2).since_last_s, 3e-3);
    EXPECT_EQ(rig.tick().missed_periods, 0U);
    EXPECT_EQ(rig.late_tick(50).safety.cause, servo::TripCause::none);
    EXPECT_EQ(rig.late_tick(1).safety.cause, servo::TripCause::missed_deadlines);
}

} // namespace
} // namespace springdrive::rig

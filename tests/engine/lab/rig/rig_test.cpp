// Covers engine/lab/rig/law_rig.cpp and servo_rig.cpp, what holds a tip in
// scenario/scenarios.cpp, limits/method_limits and
// engine/control/rendered_force.h.
#include "engine/lab/rig/law_rig.h"
#include "engine/lab/rig/servo_rig.h"

#include "engine/contact/mesh/facet.h"
#include "engine/lab/limits/method_limits/pressed_corner.h"
#include "tests/support/devices.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace springdrive::rig {
namespace {

const Vector3 kStart_m(0.01, 0.02, -0.01);

LawOptions law_options() {
    LawOptions options;
    options.device = testing::phantom_1_0();
    return options;
}

/// Somebody who presses straight down from the start.
simulated::SimulationOptions pressing() {
    simulated::SimulationOptions options;
    options.effects.gravity = false;
    options.effects.coulomb_friction = false;
    options.hand = {0.1, 20.0, 800.0, 10.0, 1.0};
    options.path = simulated::HandPath({{0.0, kStart_m}, {0.1, kStart_m - Vector3(0, 5e-3, 0)}});
    return options;
}

/// A plant that stands where it is told to.
class StandingPlant final : public Plant {
public:
    void advance(const simulated::PlantCommand &command) override { commands.push_back(command); }
    [[nodiscard]] Vector3 theta_rad() const override { return theta; }

    Vector3 theta{Vector3::Zero()};
    std::vector<simulated::PlantCommand> commands;
};

void expect_same(const device::DeviceCommand &one, const device::DeviceCommand &other) {
    EXPECT_EQ(one.mode, other.mode);
    EXPECT_EQ(one.e_W_V, other.e_W_V);
    EXPECT_EQ(one.cancelled_resistance_Ohm, other.cancelled_resistance_Ohm);
}

TEST(Constraint, OfAPlaneHoldsInsideOrOnBothSides) {
    const Vector3 normal = Vector3(1.0, 2.0, -2.0) / 3.0;
    const Constraint one = plane(kStart_m, normal, Sides::one);
    const Constraint both = plane(kStart_m, normal, Sides::both);
    const Vector3 along = Vector3(2.0, 1.0, 2.0) / 3.0; // square to it
    for (const double depth_m : {-2e-3, 2e-3}) {
        const Vector3 tip_m = kStart_m - depth_m * normal + 0.01 * along;
        EXPECT_EQ(one(tip_m).touching, depth_m > 0.0);
        EXPECT_TRUE(both(tip_m).touching);
        EXPECT_LT((both(tip_m).x0_m - (kStart_m + 0.01 * along)).norm(), 1e-15);
        EXPECT_LT((both(tip_m).tangent_projector * normal).norm(), 1e-15);
        EXPECT_LT((both(tip_m).tangent_projector * along - along).norm(), 1e-15);
    }
    const contact::Contact outside = one(kStart_m + 1e-3 * normal);
    EXPECT_EQ(outside.x0_m, kStart_m + 1e-3 * normal);
    EXPECT_EQ(outside.eta, 1.0);
    EXPECT_EQ(outside.tangent_projector, Matrix3::Identity());
}

TEST(Constraint, OfASurfaceIsItsProxys) {
    const contact::HapticSurface block(
        testing::box_soup(Vector3(-0.1, -0.1, -0.1), Vector3(0.1, 0.02, 0.1)));
    const Constraint of_surface = surface(block);
    const Constraint of_plane = plane(Vector3(0.0, 0.02, 0.0), Vector3::UnitY(), Sides::one);
    for (int i = 0; i < 100; ++i) {
        const Vector3 tip_m(0.02 * std::sin(0.2 * i), 0.02305 - 1e-4 * i, 0.0);
        const contact::Contact found = of_surface(tip_m);
        const contact::Contact truth = of_plane(tip_m);
        EXPECT_EQ(found.touching, truth.touching) << i;
        EXPECT_LT((found.x0_m - truth.x0_m).norm(), 2.0 * contact::kClearance_m) << i;
    }
}

TEST(LawRig, IsFilterLawAndPlantInTurn) {
    for (const FirstCommand first : {FirstCommand::answers, FirstCommand::brakes}) {
        const LawOptions options = law_options();
        const Constraint wall = plane(kStart_m, Vector3::UnitY(), Sides::one);
        simulated::SimulatedPhantom phantom(options.device, pressing(), kStart_m);
        PhantomPlant plant(phantom);
        LawRig rig(plant, options, wall, first);

        // The same, step by step.
        simulated::SimulatedPhantom by_hand(options.device, pressing(), kStart_m);
        const control::HapticLaw law(options.device);
        const double pole = std::exp(-options.tuning.lambda_rad_per_s * options.period_s);
        Vector3 theta_rad = by_hand.truth().theta_rad;
        Vector3 before_rad = theta_rad;
        Vector3 rate = Vector3::Zero();
        const auto answer = [&] {
            rate = pole * rate + (1.0 - pole) / options.period_s * (theta_rad - before_rad);
            before_rad = theta_rad;
            const control::Configuration now = law.configuration(theta_rad, rate);
            return law(now, wall(now.tip_m), options.tuning, {}).command;
        };
        device::DeviceCommand command =
            first == FirstCommand::answers ? answer() : device::DeviceCommand::braking();
        for (int tick = 0; tick < 200; ++tick) {
            expect_same(rig.command().spring_drive, command);
            const device::Measurement measured = by_hand.advance(command);
            theta_rad = law.theta_rad(measured.counts);
            command = answer();
            rig.tick();
            ASSERT_EQ(phantom.truth().theta_rad, by_hand.truth().theta_rad) << tick;
        }
        EXPECT_TRUE(rig.contact().touching);
        EXPECT_GT(rig.command().spring_drive.e_W_V.norm(), 0.1);
    }
}

TEST(LawRig, OfACurrentDriveRendersItsWall) {
    LawOptions options = law_options();
    options.drive = device::AmplifierKind::current_drive;
    options.wall = {1500.0, 2.0};
    simulated::SimulationOptions simulation = pressing();
    simulation.amplifier = options.drive;
    simulation.effects.magnet_heat = false; // a current drive trusts k_T
    simulation.quantised_encoders = false;
    simulated::SimulatedPhantom phantom(options.device, simulation, kStart_m);
    PhantomPlant plant(phantom);
    LawRig rig(plant, options, plane(kStart_m, Vector3::UnitY(), Sides::one),
               FirstCommand::answers);
    for (int tick = 0; tick < 2000; ++tick) {
        rig.tick();
    }
    // At rest two springs in a row share 5 mm; the hand's is soft sideways too, so but for that.
    // The wall sees the tip in counts, so a count off at most.
    const double depth_m = kStart_m.y() - phantom.truth().tip_m.y();
    const double count_m = phantom.description().rad_per_count() * rig.configuration().J.norm();
    EXPECT_NEAR(depth_m, 5e-3 * 800.0 / (800.0 + 1500.0), count_m);
    EXPECT_NEAR(-phantom.truth().hand_force_N.y(), 1500.0 * depth_m, 1500.0 * count_m);
    EXPECT_LT(count_m, 1e-3 * options.device.rad_per_count() * rig.configuration().J.norm());
}

TEST(VirtualWall, PushesOnlyUnlessItIsAPoint) {
    const control::VirtualWall wall{1000.0, 10.0};
    control::Configuration now;
    now.theta_rate_rad_per_s = Vector3(0.0, 1.0, 0.5); // J is the identity
    contact::Contact contact;
    EXPECT_EQ(control::wall_force_N(wall, now, contact, 0.0), Vector3::Zero());
    contact.touching = true;
    contact.x0_m = Vector3(0.0, 2e-3, 0.0);
    contact.normal = Vector3::UnitY();
    EXPECT_EQ(control::wall_force_N(wall, now, contact, 0.0), Vector3::Zero()); // 2 N − 10 N
    now.theta_rate_rad_per_s.y() = -1.0;
    EXPECT_EQ(control::wall_force_N(wall, now, contact, 0.0), Vector3(0.0, 12.0, 0.0));
    EXPECT_EQ(control::wall_force_N(wall, now, contact, 0.25), Vector3(0.0, 9.0, 0.0));
    contact.normal.setZero();
    now.theta_rate_rad_per_s.y() = 1.0;
    EXPECT_EQ(control::wall_force_N(wall, now, contact, 0.0), Vector3(0.0, -8.0, -5.0));
}

TEST(LawRig, CancelsWhatItIsToldToLeave) {
    LawOptions options = law_options();
    StandingPlant plant;
    const Constraint held = tied_to(Vector3(0.0, -0.01, 0.0));
    for (const double net_Ohm : {-0.2, 0.0, 0.7}) {
        options.net_resistance_Ohm = net_Ohm;
        const LawRig rig(plant, options, held, FirstCommand::answers);
        for (std::size_t j = 0; j < 3; ++j) {
            const double cancelled_Ohm =
                rig.command().spring_drive.cancelled_resistance_Ohm[static_cast<Eigen::Index>(j)];
            EXPECT_NEAR(options.device.motor[j].resistance_Ohm - cancelled_Ohm, net_Ohm, 1e-15);
        }
    }
}

TEST(LawRig, BrakesWhatRanAway) {
    LawOptions options = law_options();
    options.max_turn_rad = 100.0;
    StandingPlant plant;
    LawRig rig(plant, options, tied_to(Vector3(0.0, -0.01, 0.0)), FirstCommand::answers);
    const auto brakes_at = [&](double angle_rad) {
        plant.theta[1] = angle_rad;
        rig.tick();
        return rig.command().spring_drive.mode == device::CommandMode::brake;
    };
    EXPECT_FALSE(brakes_at(0.1));
    EXPECT_TRUE(brakes_at(101.0));
    EXPECT_TRUE(brakes_at(std::numeric_limits<double>::quiet_NaN()));
    EXPECT_FALSE(brakes_at(0.1)); // nothing of it is left in the filter
    EXPECT_TRUE(rig.command().spring_drive.e_W_V.allFinite());
}

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

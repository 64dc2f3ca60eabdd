// Covers engine/session/session_plant.cpp: changes of the simulated device while it runs.
#include "base/input_error.h"
#include "device/core/device_file.h"
#include "engine/lab/loops/hand_family.h"
#include "tests/engine/session/session_fixture.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace springdrive::session {
namespace {

using testing::run;
using testing::run_into_contact;
using testing::run_until;
using testing::scripted;

/// Without a scripted hand.
SessionOptions held(const std::string &scene = "plate") {
    SessionOptions options = scripted(scene);
    options.plays_script = false;
    return options;
}

TEST(SessionPlant, ADelayIsTheDevicesAndTheObservers) {
    const std::filesystem::path folder = testing::fresh_folder("plant_delay");
    SessionOptions options = scripted();
    options.device_seed = 7;
    options.record = folder / "touch.rec";
    Session session(options);
    session.start();
    ASSERT_TRUE(run_into_contact(session));
    const std::uint64_t next = session.latest().tick + 1;
    session.set_delay(1.5);
    EXPECT_EQ(session.device().device().delay_periods(), 1.5);
    EXPECT_EQ(session.models().ground().delay_periods, 1.5);
    run(session, 3.0);
    EXPECT_EQ(session.latest().safety.state, servo::SafetyState::running);
    // An observer that still took the delay for none would contradict itself.
    for (std::size_t motor = 1; motor < 3; ++motor) {
        EXPECT_TRUE(session.latest().motor[motor].is_trusted) << motor;
        EXPECT_FALSE(session.latest().winding[motor].is_contradicted) << motor;
    }
    for (const double wrong : {-0.1, 8.1, std::nan("")}) {
        EXPECT_THROW(session.set_delay(wrong), InputError);
        EXPECT_EQ(session.device().device().delay_periods(), 1.5);
    }
    session.stop();
    const nlohmann::json note = nlohmann::json::parse(testing::notes_in(options.record)); // one
    EXPECT_EQ(note.at("delay_periods"), 1.5);
    EXPECT_EQ(note.at("from_tick"), next);
    std::filesystem::remove_all(folder);
}

TEST(SessionPlant, WithoutGravityTheHandHoldsNoWeight) {
    Session session(held("sphere"));
    session.start();
    run(session, 2.0);
    const double sag_m = session.hand().target_m().y() - session.latest().tip_m.y();
    simulated::PlantEffects effects = session.simulation().effects;
    effects.gravity = false;
    effects.coulomb_friction = false;
    session.set_effects(effects);
    run(session, 3.0);
    const double count_m = 3e-5;               // one encoder count at the tip
    EXPECT_GT(std::abs(sag_m), 5.0 * count_m); // the links pull the tip up or down
    EXPECT_NEAR(session.latest().tip_m.y(), session.hand().target_m().y(), 2.0 * count_m);
}

TEST(SessionPlant, TolerancesOfASampledDeviceTakeAnExchange) {
    SessionOptions options = scripted();
    options.device_seed = 7;
    Session session(options);
    session.start();
    ASSERT_TRUE(run_into_contact(session));
    EXPECT_GT(session.description().motor[0].resistance_tolerance, 0.0);
    simulated::PlantEffects effects = session.simulation().effects;
    effects.gravity = false;
    session.set_effects(effects);
    EXPECT_FALSE(session.is_exchanging());
    effects.motor_tolerances = false;
    session.set_effects(effects);
    EXPECT_TRUE(session.is_exchanging());
    ASSERT_TRUE(run_until(
        session, [&] { return !session.is_exchanging(); }, 5.0));
    EXPECT_EQ(session.description().motor[0].resistance_tolerance, 0.0);
    EXPECT_FALSE(session.simulation().effects.gravity);
}

TEST(SessionPlant, EffectsThatThePlantCannotHaveChangeNothing) {
    SessionOptions options = scripted();
    options.model.plant = simulated::PlantModel{"coupling", simulated::PlantDynamics::coupling,
                                                simulated::PlantEffects::none()};
    Session session(options);
    session.start();
    simulated::PlantEffects effects = session.simulation().effects;
    effects.coulomb_friction = true;
    EXPECT_THROW(session.set_effects(effects), InputError);
    EXPECT_FALSE(session.simulation().effects.coulomb_friction);
    run(session, 0.1);
}

TEST(SessionPlant, AFirmHandGivesWayLess) {
    const auto gap_m = [](double firmness) {
        Session session(held());
        session.start();
        const loops::Hand wanted = loops::hand_of_firmness(firmness);
        device::HandParameters hand = session.simulation().hand;
        hand.mass_kg = wanted.mass_kg;
        hand.damping_Ns_per_m = wanted.damping_Ns_per_m;
        hand.stiffness_N_per_m = wanted.stiffness_N_per_m;
        session.set_hand(hand);
        EXPECT_TRUE(testing::press(session));
        run(session, 2.0);
        return (session.hand().target_m() - session.latest().tip_m).norm();
    };
    EXPECT_LT(gap_m(1.0), 0.6 * gap_m(0.5));
}

TEST(SessionPlant, APathIsFollowedFromWhereTheHandIs) {
    Session session(held());
    session.start();
    run(session, 1.0);
    const Vector3 here_m = session.hand().target_m();
    const Vector3 there_m = here_m + Vector3(0.01, 0.005, 0.0);
    const Vector3 end_m = here_m + Vector3(-0.01, 0.005, 0.0);
    session.follow_path(simulated::HandPath({{5.0, there_m}, {6.0, end_m}}));
    EXPECT_TRUE(session.hand().follows_path());
    Vector3 before_m = session.latest().tip_m;
    double farthest_m = 0.0;
    double nearest_m = 1.0;
    ASSERT_TRUE(run_until(
        session,
        [&] {
            farthest_m = std::max(farthest_m, (session.latest().tip_m - before_m).norm());
            before_m = session.latest().tip_m;
            nearest_m = std::min(nearest_m, (session.latest().tip_m - there_m).norm());
            return !session.hand().follows_path();
        },
        5.0));
    run(session, 0.5);
    EXPECT_LT(farthest_m, 4e-3 * 0.3); // frames of 4 ms, nowhere faster than 0.3 m/s
    EXPECT_LT(nearest_m, 2e-3);        // the hand is no stiffer than 300 N/m
    EXPECT_LT((session.latest().tip_m - end_m).norm(), 2e-3);
    session.hand().move_to(here_m);
    run(session, 0.5);
    EXPECT_LT((session.latest().tip_m - here_m).norm(), 2e-3);
}

TEST(SessionPlant, AnUnreachablePathIsRefused) {
    Session session(held());
    session.start();
    EXPECT_THROW(session.follow_path(simulated::HandPath({{0.0, Vector3(0.0, 2.0, 0.0)}})),
                 InputError);
    EXPECT_FALSE(session.hand().follows_path());
}

TEST(SessionPlant, WhatCannotBeChangedChangesNothing) {
    const std::filesystem::path folder = testing::fresh_folder("plant_unchanged");
    std::filesystem::copy_file(testing::assets() / "devices/phantom_1_0.toml",
                               folder / "device.toml");
    SessionOptions options = scripted();
    options.device.file = folder / "device.toml";
    options.device_seed = 7;
    Session session(options);
    session.start();
    ASSERT_TRUE(run_into_contact(session));
    const simulated::PlantEffects before = session.simulation().effects;
    simulated::PlantEffects effects = before;
    effects.motor_tolerances = false;
    effects.gravity = false;
    std::filesystem::remove(folder / "device.toml"); // from which it would start again
    EXPECT_THROW(session.set_effects(effects), InputError);
    for (const simulated::PlantEffect &effect : simulated::kPlantEffects) {
        EXPECT_EQ(session.simulation().effects.*effect.on, before.*effect.on) << effect.name;
    }
    EXPECT_FALSE(session.is_exchanging());
    // A stop is not ended by an exchange for the sake of an effect.
    session.servo().emergency_stop();
    run(session, 0.05);
    EXPECT_THROW(session.set_effects(effects), InputError);
    EXPECT_EQ(session.latest().safety.state, servo::SafetyState::tripped);
    std::filesystem::remove_all(folder);
}

TEST(SessionPlant, AnEffectDoesNotCancelAnExchange) {
    SessionOptions options = scripted();
    options.device_seed = 7;
    Session session(options);
    session.start();
    ASSERT_TRUE(run_into_contact(session));
    session.exchange_device(testing::premium());
    simulated::PlantEffects effects = session.simulation().effects;
    effects.motor_tolerances = false;
    session.set_effects(effects);
    ASSERT_TRUE(run_until(
        session, [&] { return !session.is_exchanging(); }, 5.0));
    EXPECT_EQ(session.description().name, device::read_device_file(testing::premium().file).name);
    EXPECT_FALSE(session.simulation().effects.motor_tolerances);
}

TEST(SessionPlant, HeatThatIsSwitchedOffStaysInTheWindings) {
    SessionOptions options = held();
    Session session(options);
    session.start();
    ASSERT_TRUE(testing::press(session));
    run(session, 20.0);
    const double before_N = session.latest().tip_force_N.norm();
    simulated::PlantEffects effects = session.simulation().effects;
    effects.winding_heat = false;
    session.set_effects(effects);
    run(session, 0.5);
    EXPECT_EQ(session.latest().safety.state, servo::SafetyState::running);
    EXPECT_NEAR(session.latest().tip_force_N.norm(), before_N, 0.02 * before_N);
}

TEST(SessionPlant, AHandThatLagsBehindBeginsItsPathWhereItIs) {
    Session session(held());
    session.start();
    run(session, 1.0);
    const Vector3 here_m = session.hand().target_m();
    session.hand().move_to(here_m + Vector3(0.08, 0.0, 0.0));
    session.advance(0.004); // it has hardly moved yet
    session.follow_path(simulated::HandPath({{0.0, here_m + Vector3(0.08, 0.0, 0.0)}}));
    Vector3 before_m = session.latest().tip_m;
    double fastest_m_per_s = 0.0;
    for (int frame = 0; frame < 500; ++frame) {
        session.advance(0.004);
        fastest_m_per_s =
            std::max(fastest_m_per_s, (session.latest().tip_m - before_m).norm() / 0.004);
        before_m = session.latest().tip_m;
    }
    EXPECT_LT(fastest_m_per_s, 0.15); // three times its own speed of 0.05 m/s, as it swings in
    session.leave_path();
    run(session, 0.5);
    EXPECT_FALSE(session.hand().follows_path());
    EXPECT_LT((session.latest().tip_m - session.hand().target_m()).norm(), 2e-3);
}

} // namespace
} // namespace springdrive::session

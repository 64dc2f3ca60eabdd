// Covers engine/session/session_plant.cpp: changes of the simulated device while it runs, and its
// hand; loaded_scene.cpp; and the scene of the wrong direction, touched by that hand: what the
// window measures there.
#include "base/degrees.h"
#include "base/input_error.h"
#include "device/core/device_file.h"
#include "engine/lab/loops/stability_case.h"
#include "engine/session/session.h"
#include "engine/session/telemetry_history.h"
#include "tests/engine/session/session_fixture.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <string>
#include <thread>
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
    ASSERT_TRUE(testing::run_until_exchanged(session));
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
        const loops::Hand requested = loops::hand_of_firmness(firmness);
        device::HandParameters hand = session.simulation().hand;
        hand.mass_kg = requested.mass_kg;
        hand.damping_Ns_per_m = requested.damping_Ns_per_m;
        hand.stiffness_N_per_m = requested.stiffness_N_per_m;
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
    ASSERT_TRUE(testing::run_until_exchanged(session));
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

std::filesystem::path file_of(const std::string &name) {
    return testing::assets() / "scenes" / (name + ".gltf");
}

std::unique_ptr<LoadedScene> loaded(const std::string &name) {
    scene::LoadProgress progress;
    return load_scene(file_of(name), testing::phantom_1_0().workspace, progress);
}

const LoadedScene *wait_for(Scenes &scenes) {
    const LoadedScene *before = nullptr;
    while (before == nullptr && scenes.is_loading()) {
        before = scenes.take_loaded();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return before;
}

TEST(Scenes, ThePreviousSceneStaysUntilTheServoReleasesIt) {
    Scenes scenes(testing::phantom_1_0().workspace, loaded("plate"));
    const LoadedScene *const plate = &scenes.now();
    scenes.request(file_of("sphere"));
    EXPECT_EQ(wait_for(scenes), plate);
    EXPECT_EQ(scenes.id(), 2U);
    EXPECT_EQ(scenes.now().scene.file.filename(), "sphere.gltf");
    EXPECT_EQ(plate->scene.file.filename(), "plate.gltf");
    scenes.note_in_use(1); // the servo still is on the plate
    EXPECT_EQ(scenes.retired(), 1U);
    scenes.note_in_use(2);
    EXPECT_EQ(scenes.retired(), 0U);
}

TEST(Scenes, TheLastOfSeveralRequestsCounts) {
    Scenes scenes(testing::phantom_1_0().workspace, loaded("plate"));
    for (const char *name : {"sphere", "compliance", "organic", "profile"}) {
        scenes.request(file_of(name));
    }
    wait_for(scenes);
    EXPECT_EQ(scenes.now().scene.file.filename(), "profile.gltf");
    EXPECT_EQ(scenes.id(), 2U);
    EXPECT_EQ(scenes.error(), "");
}

TEST(Scenes, AFailedSceneLeavesTheCurrentOne) {
    const std::filesystem::path folder = testing::fresh_folder("scenes");
    std::ofstream(folder / "broken.glb") << "no glTF";
    Scenes scenes(testing::phantom_1_0().workspace, loaded("plate"));
    scenes.request(folder / "broken.glb");
    EXPECT_EQ(wait_for(scenes), nullptr);
    EXPECT_NE(scenes.error().find("broken.glb"), std::string::npos);
    EXPECT_EQ(scenes.id(), 1U);
    EXPECT_EQ(scenes.now().scene.file.filename(), "plate.gltf");
    scenes.request(file_of("sphere"));
    EXPECT_NE(wait_for(scenes), nullptr);
    EXPECT_EQ(scenes.error(), "");
}

TEST(Scenes, LoadingOfACancelledSceneStops) {
    scene::LoadProgress progress;
    progress.give_up();
    EXPECT_THROW(static_cast<void>(
                     load_scene(file_of("organic"), testing::phantom_1_0().workspace, progress)),
                 Cancelled);
}

TEST(SimulatedHand, StaysWithinWorkspaceAndReachAndFollowsItsPath) {
    const device::DeviceDescription device = testing::phantom_1_0();
    SimulatedHand hand;
    hand.take_hold(nullptr, device, std::nullopt, Vector3::Zero());
    hand.move_to(Vector3(5.0, 5.0, 5.0));
    const Vector3 from_centre_m = hand.target_m() - device.workspace.centre_m;
    EXPECT_TRUE(
        (from_centre_m.cwiseAbs().array() <= 0.5 * device.workspace.size_m.array() + 1e-12).all());
    EXPECT_TRUE(device::can_reach(device, hand.target_m()));
    EXPECT_FALSE(hand.follows_path());
    hand.advance(3.0);
    EXPECT_EQ(hand.target_m() - device.workspace.centre_m, from_centre_m);
    const simulated::HandPath path({{0.0, Vector3::Zero()}, {1.0, Vector3(0.01, 0.0, 0.0)}});
    hand.take_hold(nullptr, device, path, Vector3::Zero());
    EXPECT_TRUE(hand.follows_path());
    hand.advance(1.0);
    EXPECT_EQ(hand.target_m(), Vector3(0.01, 0.0, 0.0));
    EXPECT_TRUE(hand.follows_path());
    hand.advance(1.001);
    EXPECT_EQ(hand.target_m(), Vector3(0.01, 0.0, 0.0));
    EXPECT_FALSE(hand.follows_path());
    hand.move_to(Vector3(0.0, 0.01, 0.0));
    hand.advance(1.002);
    EXPECT_EQ(hand.target_m(), Vector3(0.0, 0.01, 0.0));
}

constexpr double kDepth_m = 0.006; // of the hand's target; presses with 1.3 to 1.8 N
constexpr double kSettles_s = 1.5;

/// A session whose hand presses on the scene's spot.
class PressedSpot {
public:
    /// @param seed  which device of its kind
    explicit PressedSpot(std::uint64_t seed) : session_(options(seed)) {
        session_.start();
        testing::run(session_, 1.2); // the gains rise
        const scene::TouchSpot &spot = *session_.scenes().now().scene.lesson.spot;
        session_.hand().move_to(spot.point_m + 0.012 * spot.normal);
        testing::run(session_, 1.0);
        EXPECT_FALSE(session_.latest().contact.touching);
        session_.hand().move_to(spot.point_m - kDepth_m * spot.normal);
        testing::run(session_, kSettles_s);
    }

    void use(control::MotionMap map) {
        control::Tuning tuning = session_.latest().tuning;
        tuning.map = map;
        session_.tuning().change(tuning, session_.plot_time_s());
        testing::run(session_, kSettles_s);
    }

    /// Of the last second, the least and the largest value of a channel.
    struct Range {
        double min_deg = 180.0;
        double largest_deg = 0.0;
    };
    [[nodiscard]] Range measured(const std::string &channel) const {
        const record::ChannelStore &store = session_.servo().history().store();
        const std::size_t number = *channel_named(channel);
        Range range;
        for (std::uint64_t row = store.end() - 1000; row < store.end(); ++row) {
            const double deg = kDegreesPerRadian * store.value(number, row);
            EXPECT_TRUE(std::isfinite(deg)) << channel; // it touches, with that map
            range.min_deg = std::min(range.min_deg, deg);
            range.largest_deg = std::max(range.largest_deg, deg);
        }
        return range;
    }

    void expect_well() const {
        const servo::ServoSample &now = session_.latest();
        EXPECT_EQ(now.safety.state, servo::SafetyState::running);
        EXPECT_FALSE(now.active_limits.holds_force());
        EXPECT_GT(now.tip_force_N.norm(), 1.0);
        EXPECT_LT(now.tip_force_N.norm(), 3.0);
    }

private:
    static SessionOptions options(std::uint64_t seed) {
        SessionOptions options = testing::scripted("wrong_direction");
        options.plays_script = false;
        options.device_seed = seed;
        return options;
    }

    Session session_;
};

TEST(WrongDirectionSession, TheInverseMapIsBeyond25DegreesAndTheTransposeMapBelow5) {
    for (const std::uint64_t seed : {0U, 3U, 7U, 11U}) { // the file's own device, and drawn ones
        SCOPED_TRACE(seed);
        PressedSpot pressed(seed);
        pressed.use(control::MotionMap::inverse);
        pressed.expect_well();
        EXPECT_GT(pressed.measured("inverse_measured_rad").min_deg, 25.0);
        pressed.use(control::MotionMap::transpose);
        pressed.expect_well();
        EXPECT_LT(pressed.measured("transpose_measured_rad").largest_deg, 5.0);
    }
}

} // namespace
} // namespace springdrive::session

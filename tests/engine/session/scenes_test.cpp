// Covers engine/session/scene_loader.cpp and the hand of session_plant.cpp alone.
#include "engine/session/session.h"

#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <thread>

namespace springdrive::session {
namespace {

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
    std::filesystem::remove_all(folder);
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

} // namespace
} // namespace springdrive::session

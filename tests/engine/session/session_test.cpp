// Covers engine/session/session.cpp: everything but the window.
#include "engine/session/session.h"

#include "base/input_error.h"
#include "base/sha256.h"
#include "engine/record/record_reader.h"
#include "tests/engine/session/session_fixture.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <string>
#include <thread>

#include <malloc.h>

namespace springdrive::session {
namespace {

SessionOptions headless() {
    SessionOptions options;
    options.scene = testing::assets() / "scenes/plate.gltf";
    options.device.file = testing::assets() / "devices/phantom_1_0.toml";
    options.lockstep = true;
    options.plays_script = true;
    return options;
}

/// Runs frames until background loading is complete, plus those needed for a tick.
void wait_for_scene(Session &session) {
    while (session.scenes().is_loading()) {
        session.advance(testing::kFrame_s);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    session.advance(testing::kFrame_s);
    session.advance(testing::kFrame_s);
}

/// How many of the sixty frames after the first 2.7 s of the scripted touch end in contact.
int frames_in_contact(const std::filesystem::path &scene) {
    SessionOptions options = headless();
    options.scene = scene;
    Session session(options);
    session.start();
    testing::run(session, 2.7);
    int touching = 0;
    for (int frame = 0; frame < 60; ++frame) {
        session.advance(testing::kFrame_s);
        const servo::ServoSample &now = session.latest();
        touching += now.contact.touching ? 1 : 0;
        // The tip stays where a finger could have pushed it: near its proxy.
        EXPECT_LT((now.tip_m - now.contact.x0_m).norm(), 0.01) << scene;
    }
    EXPECT_EQ(session.latest().safety.state, servo::SafetyState::running) << scene;
    return touching;
}

TEST(Session, TheScriptedTouchTouchesEverySceneOfTheProject) {
    for (const char *name : {"plate.gltf", "slope.gltf", "wrong_direction.gltf", "compliance.gltf",
                             "stepped_block.gltf", "profile.gltf", "organic.gltf",
                             "thin_plate.gltf", "sphere.gltf", "blow.gltf"}) {
        EXPECT_GT(frames_in_contact(testing::assets() / "scenes" / name), 50) << name;
    }
    // The touch strokes the middle, where the gap between the two is.
    EXPECT_GT(frames_in_contact(testing::assets() / "scenes/spheres.gltf"), 30);
}

TEST(Session, TheScriptedTouchTouchesThirdPartyFiles) {
    const std::filesystem::path models = SPRINGDRIVE_MODELS_DIR;
    if (!std::filesystem::exists(models)) {
        GTEST_SKIP() << "no models beside the project";
    }
    // The knight's helmet has steps from which the proxy falls.
    for (const char *name : {"2CylinderEngine.glb", "Box.glb", "DenseSphere.glb",
                             "ShapeCollection.glb", "chr_knight.glb"}) {
        EXPECT_GT(frames_in_contact(models / name), 30) << name;
    }
}

TEST(Session, AFailedSceneKeepsTheOldOneAndReportsWhy) {
    const std::filesystem::path folder = testing::fresh_folder("session");
    std::ofstream(folder / "broken.glb") << "no glTF";
    Session session(headless());
    session.start();
    testing::run(session, 0.1);
    session.request_scene(folder / "broken.glb");
    wait_for_scene(session);
    EXPECT_NE(session.scenes().error().find("broken.glb"), std::string::npos);
    EXPECT_EQ(session.scenes().now().scene.file.filename(), "plate.gltf");
    EXPECT_EQ(session.scenes().id(), 1U);
    session.request_scene(testing::assets() / "scenes/sphere.gltf");
    wait_for_scene(session);
    EXPECT_EQ(session.scenes().error(), "");
    EXPECT_EQ(session.scenes().now().scene.file.filename(), "sphere.gltf");
    EXPECT_EQ(session.latest().scene_id, 2U);
    std::filesystem::remove_all(folder);
}

TEST(Session, SwitchingScenesInContactCausesNeitherTripsNorSteps) {
    Session session(headless());
    session.start();
    testing::run(session, 2.7);
    ASSERT_TRUE(session.latest().contact.touching);
    for (const char *name : {"sphere", "organic", "stepped_block", "plate"}) {
        session.request_scene(testing::assets() / "scenes" / (std::string(name) + ".gltf"));
        wait_for_scene(session);
        testing::run(session, 0.2);
        EXPECT_EQ(session.latest().safety.state, servo::SafetyState::running) << name;
        EXPECT_LT(session.latest().tip_force_N.norm(), 6.0) << name;
    }
}

TEST(Session, AnEmergencyStopBrakesUntilItIsReset) {
    SessionOptions options = headless();
    options.plays_script = false; // a resting hand
    Session session(options);
    session.start();
    testing::run(session, 1.2);
    session.servo().emergency_stop();
    testing::run(session, 0.1);
    EXPECT_EQ(session.latest().safety.cause, servo::TripCause::emergency_stop);
    EXPECT_EQ(session.latest().command.e_W_V, Vector3::Zero());
    EXPECT_EQ(session.latest().command.cancelled_resistance_Ohm, Vector3::Zero());
    session.servo().let_go_on();
    testing::run(session, 1.3); // it rests above the scene: a wait, then the ramp
    EXPECT_EQ(session.latest().safety.state, servo::SafetyState::running);
}

TEST(Session, TheMouseHandMovesTheTipWithinTheWorkspaceOnly) {
    SessionOptions options = headless();
    options.plays_script = false;
    options.effects = simulated::PlantEffects::none(); // no weight, no friction
    Session session(options);
    session.start();
    EXPECT_FALSE(session.hand().follows_path());
    testing::run(session, 1.2);
    const Vector3 goal_m = session.hand().target_m() + Vector3(0.02, -0.01, 0.01);
    session.hand().move_to(goal_m);
    testing::run(session, 2.7);
    EXPECT_LT((session.latest().tip_m - goal_m).norm(), 2e-4); // encoder counts and a soft spring
    session.hand().move_to(Vector3(5.0, 5.0, 5.0));
    const device::Workspace &box = session.description().workspace;
    EXPECT_TRUE(((session.hand().target_m() - box.centre_m).cwiseAbs().array() <=
                 0.5 * box.size_m.array() + 1e-12)
                    .all());
}

TEST(Session, ARecordHoldsEveryTickAndEveryScene) {
    const std::filesystem::path folder = testing::fresh_folder("session_record");
    SessionOptions options = headless();
    options.record = folder / "touch.rec";
    Session session(options);
    session.start();
    testing::run(session, 2.0);
    session.request_scene(testing::assets() / "scenes/sphere.gltf");
    wait_for_scene(session);
    testing::run(session, 0.5);
    const std::uint64_t ticks = session.latest().tick + 1;
    session.stop();
    EXPECT_EQ(session.recording().status().error, "");
    EXPECT_EQ(session.recording().status().rows, ticks);

    record::RecordReader record(options.record);
    EXPECT_EQ(record.header().device_toml, testing::contents_of(options.device.file));
    EXPECT_EQ(record.header().scene_sha256, sha256_of_file(options.scene));
    std::uint64_t next = 0;
    std::string notes;
    record.for_each([&](const servo::ServoSample &sample) { EXPECT_EQ(sample.tick, next++); },
                    [&](std::string_view note) { notes += note; });
    EXPECT_EQ(next, ticks);
    EXPECT_NE(notes.find("sphere.gltf"), std::string::npos);
    EXPECT_NE(notes.find(sha256_of_file(testing::assets() / "scenes/sphere.gltf")),
              std::string::npos);
    std::filesystem::remove_all(folder);
}

TEST(Session, ARecordHoldsTheDeviceIndependentlyOfItsFile) {
    const std::filesystem::path folder = testing::fresh_folder("session_device");
    SessionOptions options = headless();
    const std::string text = testing::contents_of(options.device.file);
    options.device.file = folder / "device.toml";
    std::ofstream(options.device.file) << text;
    Session session(options);
    session.start();
    std::filesystem::remove(options.device.file);
    session.start_recording(folder / "after.rec");
    testing::run(session, 0.1);
    session.stop();
    EXPECT_EQ(record::RecordReader(folder / "after.rec").header().device_toml, text);
    std::filesystem::remove_all(folder);
}

TEST(Session, ARecordThatCannotBeCreatedIsReported) {
    const std::filesystem::path folder = testing::fresh_folder("session_no_record");
    SessionOptions options = headless();
    options.record = folder / "no" / "such.rec";
    Session refused(options);
    EXPECT_THROW(refused.start(), InputError);
    options.record.clear();
    Session session(options);
    session.start();
    testing::run(session, 0.1);
    EXPECT_THROW(session.start_recording(folder / "no" / "such.rec"), InputError);
    session.start_recording(folder / "is.rec"); // another attempt succeeds
    testing::run(session, 0.1);
    session.recording().stop();
    EXPECT_EQ(session.recording().status().rows, 100U);
    EXPECT_THROW(session.start_recording(folder / "is.rec"), InputError); // nothing is overwritten
    session.stop();
    std::filesystem::remove_all(folder);
}

TEST(Session, TheSimulationWaitsWhileTheWindowIsSilent) {
    SessionOptions options = headless();
    options.lockstep = false; // the servo runs by itself
    Session session(options);
    session.start();
    session.advance(testing::kFrame_s);
    const double silence_s = session.description().limits.window_silence_s;
    std::this_thread::sleep_for(std::chrono::duration<double>(silence_s + 0.2));
    for (int frame = 0; frame < 10; ++frame) {
        session.advance(testing::kFrame_s);
        std::this_thread::sleep_for(std::chrono::duration<double>(testing::kFrame_s));
    }
    session.stop();
    EXPECT_NE(session.latest().safety.state, servo::SafetyState::tripped);
    EXPECT_GT(session.servo().stalls().seconds, 0.4 * silence_s);
    EXPECT_GT(session.servo().stalls().longest_s, 0.4 * silence_s);
    int told = 0;
    for (const std::string &warning : session.warnings().take_new()) {
        told += warning.find("the simulation waited") != std::string::npos ? 1 : 0;
    }
    EXPECT_EQ(told, 1);
}

TEST(Session, AStopAndAResetInOneFrameLeaveItStopped) {
    Session session(headless());
    session.start();
    testing::run(session, 1.2);
    session.servo().emergency_stop();
    session.servo().let_go_on(); // before any tick has seen the stop
    session.advance(1.0 / session.servo().rate_hz());
    EXPECT_EQ(session.latest().safety.cause, servo::TripCause::emergency_stop);
    session.stop();
}

TEST(Session, LimitsAreLoweredAndNeverRaised) {
    Session session(headless());
    session.start();
    testing::run(session, 0.1);
    const servo::SafetyLimits device = servo::limits_of(session.description());
    servo::SafetyLimits requested = session.servo().inputs().limits;
    requested.tip_force_N = 3.0;
    requested.current_A = 100.0;
    session.servo().lower_limits(requested);
    testing::run(session, 0.1); // it still waits, so there is no force step
    EXPECT_EQ(session.latest().limits.tip_force_N, 3.0);
    EXPECT_EQ(session.latest().limits.current_A, device.current_A);
    session.stop();
}

/// Of what is noted, only that of ticks in memory is kept, however long a session lasts.
TEST(Session, ForgetsWhatWasNotedOfTicksThatAreGone) {
    SessionOptions options = headless();
    options.history_bytes = 1; // the newest 1024 to 2047 ticks
    Session session(options);
    session.start();
    const auto note_and_run = [&](int times) {
        for (int i = 0; i < times; ++i) {
            session.set_servo_rate(i % 2 == 0 ? 500.0 : 1000.0);
            testing::run(session, 0.1);
        }
    };
    const auto in_use = [] { return static_cast<double>(mallinfo2().uordblks); };
    note_and_run(60);
    const double before = in_use();
    note_and_run(200);
    // A header takes more than 10 KiB, and fewer than 40 of the notes are of ticks in memory.
    EXPECT_LT(in_use() - before, 40 * 10 * 1024.0);

    const std::vector<Record> past = session.past();
    ASSERT_EQ(past.size(), 1U);
    const record::ChannelStore &store = session.servo().history().store();
    EXPECT_EQ(past[0].rows.from, store.begin());
    ASSERT_GT(past[0].notes.size(), 5U);
    EXPECT_LT(past[0].notes.size(), 40U);
    EXPECT_GT(past[0].notes.front().before_row, store.begin());
    session.stop();
}

} // namespace
} // namespace springdrive::session

// Covers how a session ends or stops, in engine/session/{session,session_device,servo_run}.cpp: an
// assertion that fails in the servo; a zero of the device's counts that is void, after which no
// motor is driven until somebody zeroes the device again; and its end, which is quick and clean in
// any state. The sanitizers detect leaks.
#include "base/degrees.h"
#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/lab/model_selection/selection_cache.h"
#include "engine/lab/rig/servo_rig.h"
#include "engine/record/record_file.h"
#include "engine/record/replay.h"
#include "engine/session/session.h"
#include "tests/engine/session/session_fixture.h"
#include "tests/support/servo_devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::session {
namespace {

using testing::Plant;
using testing::PlantedDevice;

/// A session on a device with a planted bug, in place of the one that it opened.
class MistakenSession {
public:
    explicit MistakenSession(bool lockstep) : session(options(lockstep)) {
        auto planted = std::make_unique<PlantedDevice>(
            Plant::in_update,
            std::vector<simulated::HandPath::Point>{{0.0, testing::kPlantedStart_m}});
        device = planted.get();
        session.recording().end_part("{}");
        session.hand().take_hold(nullptr, session.description(), std::nullopt,
                                 testing::kPlantedStart_m);
        const factory::OpenDevice opened =
            std::exchange(session.device(), factory::OpenDevice(std::move(planted), nullptr));
        session.servo().renew(*device);
        static_cast<void>(session.recording().begin_part(record::record_header(1000.0)));
    }

    static SessionOptions options(bool lockstep) {
        SessionOptions options = testing::scripted();
        options.lockstep = lockstep;
        return options;
    }

    [[nodiscard]] bool run_until_it_drives() {
        return testing::run_until(
            session,
            [&] {
                return session.latest().safety.state == servo::SafetyState::running &&
                       session.latest().command.cancelled_resistance_Ohm.minCoeff() > 1.0;
            },
            20.0);
    }

    [[nodiscard]] bool run_until_it_has_failed() {
        return testing::run_until(
            session, [&] { return session.servo().has_failed(); }, 20.0);
    }

    PlantedDevice *device = nullptr;
    Session session;
};

void expect_still_braking(const MistakenSession &mistaken) {
    const servo::ServoSample &now = mistaken.session.latest();
    EXPECT_EQ(now.safety.cause, servo::TripCause::assertion);
    EXPECT_EQ(now.command.mode, device::CommandMode::brake);
    EXPECT_EQ(mistaken.device->failures(), 1);
}

TEST(SessionAssertion, TheWindowContinuesAndTheRecordNamesTheFailure) {
    const std::filesystem::path folder = testing::fresh_folder("failed_assertion");
    const std::filesystem::path file = folder / "touch.rec";
    MistakenSession mistaken(false);
    Session &session = mistaken.session;
    session.start_recording(file);
    session.start();
    ASSERT_TRUE(mistaken.run_until_it_drives());
    mistaken.device->arm();
    ASSERT_TRUE(mistaken.run_until_it_has_failed());
    const std::uint64_t ticks = session.servo().statistics().ticks();
    session.request_scene(testing::assets() / "scenes/sphere.gltf");
    EXPECT_TRUE(testing::run_until_loaded(session)); // by the servo's sample
    session.servo().reset_safety();
    EXPECT_TRUE(testing::run_until(
        session, [&] { return session.servo().statistics().ticks() > ticks + 500; }, 20.0));
    expect_still_braking(mistaken);
    session.stop();

    const std::string where = testing::PlantedDevice::kInUpdate.condition;
    const std::string line = std::to_string(PlantedDevice::kInUpdate.line);
    std::ostringstream report;
    write_session_report(report, session);
    EXPECT_NE(report.str().find("\nsafety: stopped, internal error, assertion failed at "
                                "tests/support/servo_devices.h:" +
                                line + ": " + where + "; restart the program\n"),
              std::string::npos)
        << report.str();
    std::ostringstream errors;
    EXPECT_TRUE(was_stopped(session, errors));
    EXPECT_TRUE(record_is_whole(session, errors));

    record::RecordReader reader(file);
    record::Replay replay(testing::phantom_1_0());
    std::string notes;
    std::uint64_t failed = 0;
    reader.for_each(
        [&](const servo::ServoSample &sample) {
            replay.take(sample);
            const bool has_failed = sample.safety.cause == servo::TripCause::assertion;
            EXPECT_TRUE(has_failed || failed == 0);
            failed += has_failed ? 1 : 0;
            if (has_failed) {
                ASSERT_TRUE(sample.command.e_W_V.isZero(0.0));
                ASSERT_TRUE(sample.command.cancelled_resistance_Ohm.isZero(0.0));
            }
        },
        [&](std::string_view note) { notes += note; });
    EXPECT_EQ(reader.ending().unusable_bytes, 0U);
    EXPECT_EQ(reader.ending().missing_ticks, 0U);
    EXPECT_EQ(reader.ending().rows, session.servo().statistics().ticks());
    EXPECT_GT(failed, 500U);
    EXPECT_NE(notes.find(R"("assertion_failed":")" + where), std::string::npos) << notes;
    EXPECT_NE(notes.find(R"("file":"tests/support/servo_devices.h","line":)" + line),
              std::string::npos)
        << notes;
    EXPECT_TRUE(replay.is_identical());
    EXPECT_EQ(replay.replayed(), reader.ending().rows - failed);
}

TEST(SessionAssertion, RecordsStartedLaterOrEndedEarlyNameTheFailure) {
    const std::filesystem::path folder = testing::fresh_folder("late_assertion");
    MistakenSession mistaken(true);
    Session &session = mistaken.session;
    session.start_recording(folder / "before.rec");
    session.start();
    ASSERT_TRUE(mistaken.run_until_it_drives());
    mistaken.device->arm();
    session.servo().servo().advance(1);
    session.stop();
    EXPECT_NE(testing::notes_in(folder / "before.rec").find("assertion_failed"), std::string::npos);
    session.start_recording(folder / "after.rec");
    session.advance(testing::kFrame_s);
    session.stop();
    EXPECT_NE(testing::notes_in(folder / "after.rec").find("assertion_failed"), std::string::npos);
}

TEST(SessionAssertion, AnotherDeviceIsNotStarted) {
    MistakenSession mistaken(true);
    mistaken.session.start();
    ASSERT_TRUE(mistaken.run_until_it_drives());
    mistaken.device->arm();
    ASSERT_TRUE(mistaken.run_until_it_has_failed());
    EXPECT_NE(error_text_of([&] {
                  mistaken.session.exchange_device(testing::premium());
              }).find("tests/support/servo_devices.h:"),
              std::string::npos);
    EXPECT_FALSE(mistaken.session.servo().stop_if_released());
    testing::run(mistaken.session, 3.0);
    expect_still_braking(mistaken);
}

TEST(SessionAssertion, AnExchangeInProgressIsCancelled) {
    for (const double after_s : {0.0, 0.5, 0.9}) { // the force ramps down for a second
        MistakenSession mistaken(true);
        mistaken.session.start();
        ASSERT_TRUE(mistaken.run_until_it_drives());
        mistaken.session.exchange_device(testing::premium());
        testing::run(mistaken.session, after_s);
        ASSERT_TRUE(mistaken.session.is_exchanging());
        mistaken.device->arm();
        testing::run(mistaken.session, 3.0);
        EXPECT_FALSE(mistaken.session.is_exchanging());
        expect_still_braking(mistaken);
    }
}

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
        return testing::run_until_state(session, state, 6.0);
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

using Clock = std::chrono::steady_clock;

/// Writes a .glb of a wavy square of `cells` cells per side, with two triangles each.
std::filesystem::path write_square(const std::filesystem::path &file, std::uint32_t cells) {
    std::vector<float> positions;
    std::vector<std::uint32_t> indices;
    const std::uint32_t row = cells + 1;
    for (std::uint32_t i = 0; i < row; ++i) {
        for (std::uint32_t j = 0; j < row; ++j) {
            const float x = static_cast<float>(i) / static_cast<float>(cells);
            const float z = static_cast<float>(j) / static_cast<float>(cells);
            positions.insert(positions.end(), {x, 0.05F * std::sin(20.0F * x) * z, z});
            if (i < cells && j < cells) {
                const std::uint32_t a = i * row + j;
                indices.insert(indices.end(), {a, a + 1, a + row, a + 1, a + row + 1, a + row});
            }
        }
    }
    const std::size_t position_bytes = 4 * positions.size();
    const std::size_t index_bytes = 4 * indices.size();
    const auto text = [](std::size_t number) { return std::to_string(number); };
    std::string json =
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"accessors":[)"
        R"({"bufferView":0,"componentType":5126,"count":)" +
        text(positions.size() / 3) +
        R"(,"type":"VEC3","min":[0,-0.05,0],"max":[1,0.05,1]},{"bufferView":1,)"
        R"("componentType":5125,"count":)" +
        text(indices.size()) + R"(,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":)" +
        text(position_bytes) + R"(},{"buffer":0,"byteOffset":)" + text(position_bytes) +
        R"(,"byteLength":)" + text(index_bytes) + R"(}],"buffers":[{"byteLength":)" +
        text(position_bytes + index_bytes) + "}]}";
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::ofstream out(file, std::ios::binary);
    const auto put = [&out](std::size_t number) {
        const auto narrow = static_cast<std::uint32_t>(number);
        out.write(reinterpret_cast<const char *>(&narrow), 4);
    };
    const std::size_t binary = position_bytes + index_bytes;
    out << "glTF";
    put(2);
    put(12 + 8 + json.size() + 8 + binary);
    put(json.size());
    out << "JSON" << json;
    put(binary);
    out.write("BIN\0", 4);
    out.write(reinterpret_cast<const char *>(positions.data()),
              static_cast<std::streamsize>(position_bytes));
    out.write(reinterpret_cast<const char *>(indices.data()),
              static_cast<std::streamsize>(index_bytes));
    return file;
}

class Quitting : public ::testing::Test {
protected:
    std::filesystem::path folder = testing::fresh_folder("quitting");
};

/// Half a million triangles take some seconds. This is how long the end of a session may wait for a
/// thread to check for cancellation, with a large margin for a busy computer.
constexpr double kSoon_s = 3.0;

TEST_F(Quitting, WhileASceneLoadsEndsQuicklyInEveryStage) {
    const std::filesystem::path large = write_square(folder / "large.glb", 500);
    for (const char *stage : {"reading", "gathering", "placing", "preparing"}) {
        Clock::time_point start;
        {
            Session session(testing::scripted());
            session.start();
            session.request_scene(large);
            while (session.scenes().is_loading() &&
                   session.scenes().progress().find(stage) == std::string::npos) {
                session.advance(0.001);
            }
            start = Clock::now();
        }
        const std::chrono::duration<double> took = Clock::now() - start;
        EXPECT_LT(took.count(), kSoon_s) << stage;
    }
}

TEST_F(Quitting, AnotherSceneDoesNotWaitForTheLargeOne) {
    const std::filesystem::path large = write_square(folder / "large.glb", 500);
    Session session(testing::scripted());
    session.start();
    session.request_scene(large);
    session.advance(0.001);
    session.request_scene(testing::assets() / "scenes/sphere.gltf");
    ASSERT_TRUE(testing::run_until_loaded(session));
    EXPECT_EQ(session.scenes().now().scene.file.filename(), "sphere.gltf");
    EXPECT_EQ(session.scenes().error(), "");
}

/// Performs an action on the session, selected by a number.
void poke(Session &session, unsigned which, const std::filesystem::path &folder) {
    switch (which % 8) {
    case 0:
        session.request_scene(testing::assets() / "scenes/sphere.gltf");
        break;
    case 1:
        session.set_servo_rate(which % 16 < 8 ? 2000.0 : 1000.0);
        break;
    case 2:
        session.exchange_device(testing::premium());
        break;
    case 3:
        session.measure_model(true);
        break;
    case 4:
        if (!session.recording().is_running()) {
            static int number = 0;
            session.start_recording(folder / (std::to_string(++number) + ".rec"));
        }
        break;
    case 5:
        session.reconnect_device();
        break;
    case 6:
        session.servo().emergency_stop();
        break;
    default:
        session.stop();
        break;
    }
}

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
constexpr int kRounds = 8; // some 4 s each
#else
constexpr int kRounds = 40;
#endif

TEST_F(Quitting, AtAnyMomentEndsCleanly) {
    setenv("XDG_CACHE_HOME", folder.c_str(), 1);
    std::mt19937 random(11);
    for (int round = 0; round < kRounds; ++round) {
        SessionOptions options = testing::scripted(round % 2 == 0 ? "plate" : "organic");
        options.lockstep = round % 3 != 0;
        options.model.chooser = model_selection::cached_chooser();
        Clock::time_point start;
        std::string done;
        {
            Session session(options);
            if (round % 5 != 0) {
                session.start();
            }
            for (std::uint_fast32_t i = random() % 6; i > 0; --i) {
                const auto which = static_cast<unsigned>(random()) % 160;
                poke(session, which, folder);
                done += " " + std::to_string(which % 8);
                testing::run(session, 0.1 * static_cast<double>(random() % 4));
            }
            start = Clock::now();
        }
        const std::chrono::duration<double> took = Clock::now() - start;
        EXPECT_LT(took.count(), kSoon_s) << "after" << done;
    }
    unsetenv("XDG_CACHE_HOME");
}

} // namespace
} // namespace springdrive::session

// Covers engine/session/session.cpp and session_device.cpp: everything but the window; one exchange
// at a time, and what remains unchanged; scene, servo rate and device exchanged in contact, in
// every order, while a record runs, which is checked by tests/support/exchange_judge.h.
#include "base/input_error.h"
#include "base/sha256.h"
#include "device/core/device_file.h"
#include "engine/record/record_file.h"
#include "engine/session/session.h"
#include "tests/engine/session/session_fixture.h"
#include "tests/support/devices.h"
#include "tests/support/exchange_judge.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <malloc.h>
#include <span>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace springdrive::session {
namespace {

using testing::notes_in;
using testing::premium;
using testing::run;
using testing::run_into_contact;
using testing::run_until;
using testing::scripted;

int frames_in_contact(const std::filesystem::path &scene) {
    SCOPED_TRACE(scene);
    SessionOptions options = scripted();
    options.scene = scene;
    Session session(options);
    return testing::frames_in_contact(session);
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

TEST(Session, ARecordHoldsEveryTickAndEveryScene) {
    const std::filesystem::path folder = testing::fresh_folder("session_record");
    SessionOptions options = scripted();
    options.record = folder / "touch.rec";
    Session session(options);
    session.start();
    testing::run(session, 2.0);
    session.request_scene(testing::assets() / "scenes/sphere.gltf");
    ASSERT_TRUE(testing::run_until_loaded(session));
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
}

TEST(Session, ARecordHoldsTheDeviceIndependentlyOfItsFile) {
    const std::filesystem::path folder = testing::fresh_folder("session_device");
    SessionOptions options = scripted();
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
}

TEST(Session, ARecordThatCannotBeCreatedIsReported) {
    const std::filesystem::path folder = testing::fresh_folder("session_no_record");
    SessionOptions options = scripted();
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
}

TEST(Session, TheSimulationWaitsWhileTheWindowIsSilent) {
    SessionOptions options = scripted();
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

/// Of what is noted, only that of ticks in memory is kept, however long a session lasts.
TEST(Session, ForgetsWhatWasNotedOfTicksThatAreGone) {
    SessionOptions options = scripted();
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

bool exchange_to_the_end(Session &session, const DeviceChoice &choice) {
    session.exchange_device(choice);
    return testing::run_until_exchanged(session);
}

TEST(SessionDevice, AnotherDeviceStartsAsUsual) {
    Session session(scripted());
    session.start();
    ASSERT_TRUE(run_into_contact(session));
    const std::uint64_t tick = session.latest().tick;
    session.exchange_device(premium());
    EXPECT_TRUE(session.is_exchanging());
    run(session, 0.5);
    EXPECT_EQ(session.latest().safety.state, servo::SafetyState::releasing); // half-way down
    EXPECT_NEAR(session.latest().safety.ramp, 0.5, 0.02);
    ASSERT_TRUE(testing::run_until_exchanged(session, 1.0));
    EXPECT_NEAR(static_cast<double>(session.latest().tick - tick), 1000.0, 20.0);
    EXPECT_EQ(session.description().name, device::read_device_file(premium().file).name);
    session.advance(0.002);
    EXPECT_LT(session.latest().tick, 2U);
    EXPECT_EQ(session.latest().safety.state, servo::SafetyState::waiting);
    EXPECT_FALSE(session.latest().contact.touching);
    EXPECT_TRUE(run_into_contact(session));
    EXPECT_EQ(session.servo().statistics().ticks(), session.latest().tick + 1);
}

TEST(SessionDevice, AFailedExchangeKeepsTheOldDevice) {
    const std::filesystem::path folder = testing::fresh_folder("no_device");
    std::ofstream(folder / "broken.toml") << "name = 7\n";
    Session session(scripted());
    session.start();
    ASSERT_TRUE(run_into_contact(session));
    DeviceChoice usb = scripted().device;
    usb.kind = factory::DeviceKind::usb;
    DeviceChoice unknown = scripted().device;
    unknown.serial = "4711";
    DeviceChoice broken;
    broken.file = folder / "broken.toml";
    for (const DeviceChoice &choice : {usb, unknown, broken}) {
        EXPECT_THROW(session.exchange_device(choice), InputError);
        EXPECT_FALSE(session.is_exchanging());
        run(session, 0.1);
        EXPECT_EQ(session.latest().safety.state, servo::SafetyState::running);
        EXPECT_EQ(session.device().state(), factory::DeviceState::zeroed);
    }
}

TEST(SessionDevice, TheRecordContinuesInANewFileForTheOtherDevice) {
    const std::filesystem::path folder = testing::fresh_folder("record_parts");
    std::ofstream(folder / "touch-2.rec") << "of somebody else";
    SessionOptions options = scripted();
    options.record = folder / "touch.rec";
    Session session(options);
    session.start();
    ASSERT_TRUE(run_into_contact(session));
    ASSERT_TRUE(exchange_to_the_end(session, premium()));
    run(session, 0.2);
    ASSERT_TRUE(exchange_to_the_end(session, scripted().device));
    run(session, 0.2);
    session.stop();
    const std::vector<std::filesystem::path> expected{folder / "touch.rec", folder / "touch-3.rec",
                                                      folder / "touch-4.rec"};
    ASSERT_EQ(session.recording().parts(), expected);
    EXPECT_EQ(record::RecordReader(expected[0]).header().device_name, "PHANTOM 1.0");
    EXPECT_EQ(record::RecordReader(expected[1]).header().device_toml,
              testing::contents_of(premium().file));
    EXPECT_EQ(record::RecordReader(expected[2]).header().device_name, "PHANTOM 1.0");
    EXPECT_NE(notes_in(expected[0]).find("exchanged"), std::string::npos);
    EXPECT_NE(notes_in(expected[1]).find("touch.rec"), std::string::npos);
    std::string warnings;
    for (const std::string &warning : session.warnings().take_new()) {
        warnings += warning;
    }
    EXPECT_NE(warnings.find("touch-3.rec"), std::string::npos);
    EXPECT_EQ(testing::contents_of(folder / "touch-2.rec"), "of somebody else");
}

TEST(SessionDevice, AReconnectedDeviceStaysTrippedUntilAReset) {
    Session session(scripted());
    session.start();
    ASSERT_TRUE(run_into_contact(session));
    session.device().close(); // as if it had been unplugged
    run(session, 0.05);
    EXPECT_EQ(session.latest().safety.cause, servo::TripCause::device_lost);
    const Vector3 tip_m = session.latest().tip_m;
    session.reconnect_device();
    EXPECT_EQ(session.device().state(), factory::DeviceState::zeroed);
    session.advance(0.001);
    EXPECT_LT((session.latest().tip_m - tip_m).norm(), 1e-3); // at its last known position
    run(session, 0.1);
    EXPECT_EQ(session.latest().safety.cause, servo::TripCause::device_lost);
    EXPECT_EQ(session.latest().command.e_W_V, Vector3::Zero());
    session.servo().reset_safety();
    run(session, 0.1);
    EXPECT_NE(session.latest().safety.state, servo::SafetyState::tripped)
        << servo::description(session.latest().safety);
    session.reconnect_device(Vector3(0.1, 0.2, 0.3)); // or at a given position
    session.advance(0.001);
    EXPECT_LT((session.latest().theta_rad - Vector3(0.1, 0.2, 0.3)).norm(), 0.05);
}

TEST(SessionDevice, AnotherRateContinuesInTheSameFileWithANote) {
    const std::filesystem::path folder = testing::fresh_folder("record_rates");
    SessionOptions options = scripted();
    options.record = folder / "touch.rec";
    Session session(options);
    session.start();
    ASSERT_TRUE(run_into_contact(session));
    const std::uint64_t next = session.latest().tick + 1;
    session.set_servo_rate(4000.0);
    EXPECT_EQ(session.servo().rate_hz(), 4000.0);
    EXPECT_EQ(session.servo().statistics().ticks(), 0U); // they restart with each rate
    run(session, 0.5);
    EXPECT_NEAR(static_cast<double>(session.servo().statistics().ticks()), 2000.0, 1.0);
    EXPECT_THROW(session.set_servo_rate(7.0), InputError);
    EXPECT_EQ(session.servo().rate_hz(), 4000.0);
    EXPECT_EQ(session.latest().safety.state, servo::SafetyState::running);
    session.stop();
    ASSERT_EQ(session.recording().parts().size(), 1U);
    const std::string notes = notes_in(options.record);
    const nlohmann::json note = nlohmann::json::parse(notes);
    EXPECT_EQ(note.at("servo_hz"), 4000.0);
    EXPECT_EQ(note.at("from_tick"), next);
}

TEST(SessionDevice, AnotherRateDoesNotClearATrip) {
    Session session(scripted());
    session.start();
    ASSERT_TRUE(run_into_contact(session));
    session.servo().emergency_stop();
    run(session, 0.05);
    session.servo().let_go_on();
    session.servo().emergency_stop();
    for (const double servo_hz : {500.0, 2000.0}) {
        session.set_servo_rate(servo_hz);
        run(session, 0.05);
        EXPECT_EQ(session.latest().safety.cause, servo::TripCause::emergency_stop) << servo_hz;
    }
}

TEST(SessionDevice, TheReportNamesTheDeviceAndThePauses) {
    Session session(scripted());
    session.start();
    run(session, 0.1);
    session.stop();
    std::ostringstream out;
    write_session_json(out, session);
    const nlohmann::json json = nlohmann::json::parse(out.str());
    EXPECT_EQ(json.at("device").at("kind"), "simulated");
    EXPECT_EQ(json.at("stood_still").at("times"), 0);
    EXPECT_EQ(json.at("stood_still").at("seconds"), 0.0);
    for (const char *key : {"read", "compute", "write", "jitter", "period"}) {
        EXPECT_TRUE(json.at(key).contains("p99_s")) << key;
    }
    std::ostringstream text;
    write_session_report(text, session);
    EXPECT_EQ(text.str().find("missed"), std::string::npos); // a simulated device misses nothing
}

using testing::press;

enum class Exchange : std::uint8_t { scene, rate, device };
constexpr std::array kExchanges{Exchange::scene, Exchange::rate, Exchange::device};

/// In which each order of three, with repetitions, comes once: a de Bruijn sequence.
std::vector<Exchange> in_every_order() {
    std::vector<Exchange> exchanges;
    for (const char number : std::string("00010020110120210221112122200")) {
        exchanges.push_back(kExchanges.at(static_cast<std::size_t>(number - '0')));
    }
    return exchanges;
}

/// A session with cyclic requests for the next scene, rate or device.
class Requested {
public:
    explicit Requested(Session &session) : session_(session) {}

    void ask(Exchange exchange) {
        constexpr std::array kScenes{"sphere", "organic", "plate"};
        constexpr std::array kRates_hz{2000.0, 1250.0, 1000.0};
        const std::size_t turn = turn_++;
        switch (exchange) {
        case Exchange::scene:
            session_.request_scene(testing::assets() / "scenes" /
                                   (std::string(kScenes[turn % 3]) + ".gltf"));
            break;
        case Exchange::rate:
            session_.set_servo_rate(kRates_hz[turn % 3]);
            break;
        case Exchange::device:
            session_.exchange_device(turn % 2 == 0 ? testing::premium()
                                                   : testing::scripted().device);
            ++devices;
            break;
        }
    }

    [[nodiscard]] bool is_done() const {
        return !session_.is_exchanging() && !session_.scenes().is_loading();
    }

    std::size_t devices = 0;

private:
    Session &session_;
    std::size_t turn_ = 0;
};

/// All files of a record together.
struct Sum {
    testing::JudgedRecord worst;
    std::size_t parts = 0;

    void add(const testing::JudgedRecord &part) {
        ++parts;
        worst.rows += part.rows;
        worst.felt += part.felt;
        worst.scenes += part.scenes;
        worst.rates += part.rates;
        worst.max_transfer_offset_V =
            std::max(worst.max_transfer_offset_V, part.max_transfer_offset_V);
    }
};

/// Checks every part of a session's record.
Sum judged(const Session &session) {
    Sum sum;
    for (const std::filesystem::path &part : session.recording().parts()) {
        const testing::JudgedRecord found = testing::judge_record(part);
        EXPECT_EQ(found.first_fault, "") << part;
        EXPECT_TRUE(found.replays) << part;
        sum.add(found);
    }
    EXPECT_EQ(session.recording().status().error, "");
    EXPECT_EQ(session.recording().status().lost, 0U);
    EXPECT_EQ(session.recording().status().rows, sum.worst.rows);
    return sum;
}

/// @param together  so many are requested at once, in contact, before it waits for them
Sum exchange_in_contact(SessionOptions options, std::span<const Exchange> exchanges,
                        std::size_t together) {
    const std::filesystem::path folder = testing::fresh_folder("exchange");
    options.plays_script = false;
    options.record = folder / "touch.rec";
    Session session(options);
    Requested requested(session);
    session.start();
    std::string so_far;
    for (std::size_t i = 0; i < exchanges.size(); ++i) {
        so_far += std::to_string(static_cast<int>(exchanges[i]));
        SCOPED_TRACE(so_far);
        if (requested.is_done()) {
            EXPECT_TRUE(press(session));
        }
        requested.ask(exchanges[i]);
        if ((i + 1) % together == 0) {
            EXPECT_TRUE(run_until(
                session, [&] { return requested.is_done(); }, 20.0));
        }
    }
    EXPECT_TRUE(press(session)); // everything is in use, and in contact
    session.stop();
    EXPECT_EQ(session.scenes().error(), "");
    const Sum sum = judged(session);
    if (together == 1) {
        EXPECT_EQ(sum.parts, 1 + requested.devices);
    }
    return sum;
}

/// In three sessions, so that their records stay short.
void exchange_in_every_order(std::span<const Exchange> exchanges, std::size_t in_a_session,
                             std::size_t together) {
    Sum all;
    for (std::size_t first = 0; first < 27 * together; first += 9 * together) {
        all.add(exchange_in_contact(testing::scripted(), exchanges.subspan(first, in_a_session),
                                    together)
                    .worst);
    }
    EXPECT_GT(all.worst.felt, 5'000U); // not vacuous
    EXPECT_GE(all.worst.scenes, 9U);
    EXPECT_GE(all.worst.rates, 9U);
    EXPECT_GT(all.worst.max_transfer_offset_V, 0.2);
}

TEST(Exchange, InContactOneByOneInEveryOrderCausesNoSteps) {
    exchange_in_every_order(in_every_order(), 9 + 2, 1);
}

TEST(Exchange, InContactSimultaneouslyInEveryOrderCausesNoSteps) {
    const std::vector<Exchange> sequence = in_every_order();
    std::vector<Exchange> threes;
    for (std::size_t first = 0; first + 3 <= sequence.size(); ++first) {
        threes.insert(threes.end(), &sequence[first], &sequence[first] + 3);
    }
    exchange_in_every_order(threes, 9 * 3, 3);
}

TEST(Exchange, OnTheRealThreadTheSameHolds) {
    SessionOptions options = testing::scripted();
    options.lockstep = false;
    const std::array order{Exchange::rate, Exchange::scene, Exchange::device};
    const Sum sum = exchange_in_contact(options, order, 1);
    EXPECT_GT(sum.worst.felt, 100U);
    EXPECT_EQ(sum.parts, 2U);
}

} // namespace
} // namespace springdrive::session

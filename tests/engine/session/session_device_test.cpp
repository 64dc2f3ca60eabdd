// Covers engine/session/session_device.cpp, and set_servo_rate: one exchange at a time, and what
// remains unchanged.
#include "base/input_error.h"
#include "device/core/device_file.h"
#include "engine/record/record_reader.h"
#include "engine/session/session_report.h"
#include "tests/engine/session/session_fixture.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <sstream>
#include <string>

namespace springdrive::session {
namespace {

using testing::notes_in;
using testing::premium;
using testing::run;
using testing::run_into_contact;
using testing::run_until;
using testing::scripted;

bool exchange_to_the_end(Session &session, const DeviceChoice &choice) {
    session.exchange_device(choice);
    return run_until(
        session, [&] { return !session.is_exchanging(); }, 5.0);
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
    ASSERT_TRUE(run_until(
        session, [&] { return !session.is_exchanging(); }, 1.0));
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
    std::filesystem::remove_all(folder);
}

TEST(SessionDevice, AnEmergencyStopPersistsThroughAnExchange) {
    Session session(scripted());
    session.start();
    ASSERT_TRUE(run_into_contact(session));
    session.servo().emergency_stop();
    run(session, 0.1);
    ASSERT_TRUE(exchange_to_the_end(session, premium())); // immediately: it is already braking
    run(session, 1.0);
    EXPECT_EQ(session.latest().safety.cause, servo::TripCause::emergency_stop);
    session.servo().let_go_on();
    EXPECT_TRUE(run_into_contact(session));
}

TEST(SessionDevice, AClearedStopDoesNotStopTheNextDevice) {
    Session session(scripted());
    session.start();
    ASSERT_TRUE(run_into_contact(session));
    session.servo().emergency_stop();
    run(session, 0.1);
    session.servo().let_go_on();
    run(session, 0.1);
    ASSERT_TRUE(exchange_to_the_end(session, premium()));
    EXPECT_TRUE(run_into_contact(session));
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
    std::filesystem::remove_all(folder);
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
    std::filesystem::remove_all(folder);
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

} // namespace
} // namespace springdrive::session

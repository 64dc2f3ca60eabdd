// Covers engine/session/session.cpp, session_device.cpp and servo_run.cpp: an assertion that fails
// in the servo.
#include "base/error_text.h"
#include "engine/record/record_reader.h"
#include "engine/record/replay.h"
#include "engine/session/session_report.h"
#include "tests/engine/session/session_fixture.h"
#include "tests/support/planted_device.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
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
                                "tests/support/planted_device.h:" +
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
    EXPECT_NE(notes.find(R"("file":"tests/support/planted_device.h","line":)" + line),
              std::string::npos)
        << notes;
    EXPECT_TRUE(replay.is_identical());
    EXPECT_EQ(replay.replayed(), reader.ending().rows - failed);
    std::filesystem::remove_all(folder);
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
    std::filesystem::remove_all(folder);
}

TEST(SessionAssertion, AnotherDeviceIsNotStarted) {
    MistakenSession mistaken(true);
    mistaken.session.start();
    ASSERT_TRUE(mistaken.run_until_it_drives());
    mistaken.device->arm();
    ASSERT_TRUE(mistaken.run_until_it_has_failed());
    EXPECT_NE(error_text_of([&] {
                  mistaken.session.exchange_device(testing::premium());
              }).find("tests/support/planted_device.h:"),
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

} // namespace
} // namespace springdrive::session

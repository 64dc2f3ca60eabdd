// Covers app/exhibit/{day_log,trip_recovery}.cpp: what of a day is logged, and how a stop is
// recovered, in simulated time.
#include "app/exhibit/day_log.h"
#include "app/exhibit/trip_recovery.h"
#include "tests/engine/session/session_fixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <string>
#include <vector>

namespace springdrive::app::exhibit {
namespace {

std::chrono::system_clock::time_point at_local(const char *time) {
    std::tm parts{};
    EXPECT_NE(strptime(time, "%Y-%m-%d %H:%M:%S", &parts), nullptr);
    parts.tm_isdst = -1;
    return std::chrono::system_clock::from_time_t(std::mktime(&parts));
}

TEST(ExhibitDayLog, AppendsOneLineAnEventWithTheLocalTime) {
    const std::filesystem::path file = testing::fresh_folder("day_log") / "new folder" / "day.log";
    {
        DayLog log(file);
        log.record("visitor 1 begins", at_local("2026-11-25 10:03:21"));
    }
    DayLog again(file); // of a second run on the same day
    again.record("two\nlines", at_local("2026-11-25 10:05:00"));
    EXPECT_EQ(testing::contents_of(file), "2026-11-25 10:03:21  visitor 1 begins\n"
                                          "2026-11-25 10:05:00  two lines\n");
    EXPECT_EQ(again.take_error(), "");
    DayLog silent{std::filesystem::path()};
    silent.record("one");
    EXPECT_EQ(silent.take_error(), "");
}

TEST(ExhibitDayLog, AFullDiskIsSaidOnceAndWhatIsMissingLater) {
    const std::filesystem::path folder = testing::fresh_folder("day_log_full");
    const std::filesystem::path file = folder / "day.log";
    std::filesystem::create_symlink("/dev/full", file); // each write fails, as on a full disk
    DayLog log(file);
    log.record("one");
    EXPECT_NE(log.take_error().find("disk full"), std::string::npos);
    log.record("two");
    log.record("three");
    EXPECT_EQ(log.take_error(), "");
    std::filesystem::remove(file); // there is room again
    log.record("four", at_local("2026-11-25 10:00:00"));
    log.record("five", at_local("2026-11-25 10:00:01"));
    EXPECT_EQ(testing::contents_of(file),
              "2026-11-25 10:00:00  3 lines before this one could not be written\n"
              "2026-11-25 10:00:00  four\n"
              "2026-11-25 10:00:01  five\n");
}

/// Against the telemetry itself, row by row, however many ticks a frame has.
TEST(ExhibitDayWatch, FindsStopsAndThePeaksOfWhatIsDriven) {
    session::SessionOptions options = testing::scripted("plate");
    session::Session session(options);
    session.start();
    DayWatch watch;
    DayFigures figures;
    std::vector<std::string> events;
    const auto run = [&](double seconds) {
        for (double passed_s = 0.0; passed_s < seconds; passed_s += testing::kFrame_s) {
            session.advance(testing::kFrame_s);
            for (std::string &event : watch.update(session, figures)) {
                events.push_back(std::move(event));
            }
        }
    };
    run(4.0);
    ASSERT_TRUE(session.latest().contact.touching);
    EXPECT_TRUE(events.empty());
    session.servo().emergency_stop();
    run(1.0);
    session.leave_path();
    session.hand().move_to(session.hand().target_m() + Vector3(0.0, 0.05, 0.0));
    run(1.0);
    session.servo().let_go_on();
    run(3.0);
    ASSERT_EQ(events.size(), 2U);
    EXPECT_EQ(events[0], "stopped: emergency stop");
    EXPECT_TRUE(events[1].starts_with("running again after ")) << events[1];
    EXPECT_EQ(figures.trips, 1U);
    EXPECT_EQ(figures.recovered, 1U);
    EXPECT_EQ(figures.losses, 0U);
    EXPECT_NEAR(figures.longest_recovery_s, 3.2, 0.3); // 2 s, rest, and the gains' second
    const record::ChannelStore &store = session.servo().history().store();
    double peak_N = 0.0;
    double peak_V = 0.0;
    for (std::uint64_t row = store.begin(); row < store.end(); ++row) {
        const servo::ServoSample sample = session::sample_at(store, row);
        if (servo::lets_pass(sample.safety.state)) {
            peak_N = std::max(peak_N, sample.tip_force_N.norm());
            peak_V = std::max(peak_V, sample.command.e_W_V.cwiseAbs().maxCoeff());
        }
    }
    EXPECT_GT(peak_N, 0.5);
    EXPECT_DOUBLE_EQ(figures.peak_force_N, peak_N);
    EXPECT_DOUBLE_EQ(figures.peak_voltage_V, peak_V);

    // A stop before the motors ran again: both are recovered at once.
    events.clear();
    session.servo().emergency_stop();
    run(1.0);
    session.servo().let_go_on();
    run(0.2);
    session.servo().emergency_stop();
    run(1.0);
    session.servo().let_go_on();
    run(3.0);
    ASSERT_EQ(events.size(), 3U);
    EXPECT_EQ(events[0], "stopped: emergency stop");
    EXPECT_EQ(events[1], "stopped: emergency stop");
    EXPECT_TRUE(events[2].starts_with("running again after ")) << events[2];
    EXPECT_EQ(figures.trips, 3U);
    EXPECT_EQ(figures.trips_during_recovery, 1U);
    EXPECT_EQ(figures.recovered, 2U);
    session.stop();
}

TEST(ExhibitDayLog, SumsUp) {
    DayFigures figures;
    figures.visitors = 40;
    figures.scenes = 112;
    figures.peak_force_N = 3.456;
    EXPECT_EQ(summary_of(figures),
              "40 visitors, 112 scenes; 0 stops, 0 healed; the device was lost 0 times; "
              "peak force 3.46 N, peak voltage 0.00 V; longest frame 0 ms");
    figures.trips = 4;
    figures.trips_during_recovery = 1;
    figures.recovered = 3;
    figures.longest_recovery_s = 11.2;
    EXPECT_TRUE(
        summary_of(figures).starts_with("40 visitors, 112 scenes; 4 stops (1 while healing), "
                                        "3 healed, the longest after 11 s; "))
        << summary_of(figures);
}

using servo::SafetyState;
using servo::TripCause;

constexpr double kRecoveryFrame_s = 0.125; // sums of it are exact

RecoveryState stopped_by(TripCause cause) {
    return {.state = SafetyState::tripped, .cause = cause};
}

class Patient {
public:
    /// The time until the first remedy; `limit_s` if there was none.
    double until_remedy_s(RecoveryState now, double limit_s) {
        const double begin_s = time_s_;
        while (time_s_ - begin_s < limit_s - 1e-9) {
            time_s_ += kRecoveryFrame_s;
            now.time_s = time_s_;
            last = recovery.update(now);
            if (last != Remedy::none) {
                return time_s_ - begin_s;
            }
        }
        return limit_s;
    }
    void pass(RecoveryState now, double seconds) {
        EXPECT_EQ(until_remedy_s(now, seconds), seconds);
    }

    TripRecovery recovery;
    Remedy last = Remedy::none;

private:
    double time_s_ = 100.0;
};

TEST(ExhibitRecovery, ResetsAfterAPause) {
    Patient patient;
    const RecoveryState now = stopped_by(TripCause::tip_speed);
    EXPECT_NEAR(patient.until_remedy_s(now, 20.0), TripRecovery::kPause_s, 1.5 * kRecoveryFrame_s);
    EXPECT_EQ(patient.last, Remedy::reset);
    EXPECT_NEAR(patient.until_remedy_s(now, 20.0), TripRecovery::kPause_s,
                1.5 * kRecoveryFrame_s); // in vain
    patient.pass({}, 1.0);
    EXPECT_EQ(patient.recovery.condition(), Condition::well);
}

TEST(ExhibitRecovery, WaitsUntilTheHandIsLetGoAndTheTipIsFree) {
    Patient patient;
    RecoveryState now = stopped_by(TripCause::tip_force);
    now.hand_is_held = true;
    now.is_touching = true;
    patient.pass(now, 60.0);
    EXPECT_EQ(patient.recovery.condition(), Condition::let_go);
    now.hand_is_held = false;
    EXPECT_NEAR(patient.until_remedy_s(now, 20.0), kRecoveryFrame_s, 1e-6);
    EXPECT_EQ(patient.last, Remedy::retract_hand);
    now.is_touching = false;
    patient.pass(now, TripRecovery::kPause_s - 0.5 * kRecoveryFrame_s);
    EXPECT_EQ(patient.recovery.condition(), Condition::pause);
    EXPECT_LT(patient.recovery.goes_on_in_s(), 2.0 * kRecoveryFrame_s);
    EXPECT_LE(patient.until_remedy_s(now, 20.0), 2.0 * kRecoveryFrame_s);
    EXPECT_EQ(patient.last, Remedy::reset);
}

TEST(ExhibitRecovery, LeavesAStopThatSomebodyRequestedToAPerson) {
    for (const TripCause cause : {TripCause::emergency_stop, TripCause::tip_speed}) {
        Patient patient;
        RecoveryState now = stopped_by(cause);
        patient.pass(now, TripRecovery::kPause_s - 1.0); // the pause has begun
        now.is_stop_held = true;
        patient.pass(now, 3600.0);
        EXPECT_EQ(patient.recovery.condition(), Condition::asks_go_on);
    }
}

TEST(ExhibitRecovery, LeavesADeviceThatCanReachAHandToAPersonAfterAnyCause) {
    for (std::size_t cause = 1; cause < servo::kTripCauseNames.size(); ++cause) {
        Patient patient;
        RecoveryState now = stopped_by(static_cast<TripCause>(cause));
        const bool is_final = now.cause == TripCause::assertion;
        if (is_final) { // a simulation, too
            patient.pass(now, 3600.0);
            EXPECT_EQ(patient.recovery.condition(), Condition::needs_staff);
        }
        now.can_reach_a_hand = true;
        now.is_lost = now.cause == TripCause::device_lost;
        patient.pass(now, 600.0);
        EXPECT_EQ(patient.recovery.condition() == Condition::lost, now.is_lost);
        now.is_lost = false;
        patient.pass(now, 600.0);
        EXPECT_EQ(patient.recovery.condition(),
                  is_final ? Condition::needs_staff : Condition::asks_go_on);
    }
}

/// A fault that comes back: a few trials, then a person is asked.
TEST(ExhibitRecovery, GivesUpAfterAFewResetsInVain) {
    Patient patient;
    const RecoveryState now = stopped_by(TripCause::tip_speed);
    const RecoveryState running{.state = SafetyState::running};
    for (int round = 0; round < 2; ++round) {
        for (int i = 0; i < TripRecovery::kMaxResets; ++i) {
            EXPECT_NEAR(patient.until_remedy_s(now, 100.0), TripRecovery::kPause_s,
                        1.5 * kRecoveryFrame_s);
            patient.pass(running, TripRecovery::kProven_s - 2.0 * kRecoveryFrame_s);
        }
        patient.pass(now, 3600.0);
        EXPECT_EQ(patient.recovery.condition(), Condition::asks_go_on);
        patient.recovery.begin_anew();
    }
    EXPECT_NEAR(patient.until_remedy_s(now, 100.0), TripRecovery::kPause_s, 1.5 * kRecoveryFrame_s);
    patient.pass(running, TripRecovery::kProven_s + 2.0 * kRecoveryFrame_s); // it was not in vain
    for (int i = 0; i < TripRecovery::kMaxResets; ++i) {
        EXPECT_LT(patient.until_remedy_s(now, 100.0),
                  TripRecovery::kPause_s + 2.0 * kRecoveryFrame_s);
    }
}

TEST(ExhibitRecovery, LiftsATipThatMotorsWaitForUnlessItIsHeld) {
    Patient patient;
    RecoveryState now;
    now.is_touching = true;
    now.hand_is_held = true;
    patient.pass(now, 60.0);
    EXPECT_EQ(patient.recovery.condition(), Condition::lift);
    now.hand_is_held = false;
    EXPECT_NEAR(patient.until_remedy_s(now, 20.0), TripRecovery::kLift_s, 1.5 * kRecoveryFrame_s);
    EXPECT_EQ(patient.last, Remedy::retract_hand);
    now.state = SafetyState::running; // that is what it is there for
    patient.pass(now, 60.0);
    EXPECT_EQ(patient.recovery.condition(), Condition::well);
    now.is_inside = true;
    EXPECT_LT(patient.until_remedy_s(now, 20.0), TripRecovery::kLift_s + 2.0 * kRecoveryFrame_s);
    patient.pass({.is_zeroed = false}, 60.0);
    EXPECT_EQ(patient.recovery.condition(), Condition::needs_zeroing);
    patient.pass({.is_limited = true}, 60.0);
    EXPECT_EQ(patient.recovery.condition(), Condition::needs_staff);
}

/// A session that is recovered as the exhibit's is, with the lines of its log.
class Recovered {
public:
    explicit Recovered(const std::vector<const char *> &faults = {}) : session(options(faults)) {
        session.start();
        session.hand().move_to({0.0, 0.03, 0.0});
        pass_until(SafetyState::running, 6.0);
    }

    static session::SessionOptions options(const std::vector<const char *> &faults) {
        session::SessionOptions options = testing::scripted();
        options.plays_script = false;
        options.servo_hz = 500.0;
        if (!faults.empty()) {
            options.device.kind = factory::DeviceKind::emulated;
            options.starts_at_zero = true;
        }
        for (const char *const fault : faults) {
            options.emulation.faults.push_back(device::parse_fault(fault));
        }
        return options;
    }
    void pass(double seconds) {
        for (double passed_s = 0.0; passed_s < seconds; passed_s += testing::kFrame_s) {
            session.advance(testing::kFrame_s);
            for (std::string &line : watch.update(session, figures)) {
                log.push_back(std::move(line));
            }
            RecoveryState now = recovery_of(session);
            now.time_s = session.latest().time_s;
            if (recovery.update(now) == Remedy::reset) {
                session.servo().reset_safety();
                ++resets;
            }
        }
    }
    void pass_until(SafetyState state, double at_most_s) {
        for (double passed_s = 0.0; passed_s < at_most_s; passed_s += testing::kFrame_s) {
            if (session.latest().safety.state == state) {
                return;
            }
            pass(0.5 * testing::kFrame_s);
        }
        ADD_FAILURE() << "not reached: " << servo::description(session.latest().safety);
    }
    void expect_stays_stopped(double seconds) {
        for (double passed_s = 0.0; passed_s < seconds; passed_s += testing::kFrame_s) {
            pass(0.5 * testing::kFrame_s);
            ASSERT_EQ(session.latest().safety.state, SafetyState::tripped);
            ASSERT_EQ(session.latest().command.e_W_V, Vector3::Zero());
        }
        EXPECT_EQ(recovery.condition(), Condition::asks_go_on);
    }
    void expect_goes_on() {
        session.servo().let_go_on();
        recovery.begin_anew();
        pass_until(SafetyState::running, 6.0);
        EXPECT_TRUE(!log.empty() && log.back().starts_with("running again after "));
    }
    [[nodiscard]] auto said(const std::string &line) const { return std::ranges::count(log, line); }

    session::Session session;
    TripRecovery recovery;
    DayWatch watch;
    DayFigures figures;
    std::vector<std::string> log;
    int resets = 0;
};

/// By a limit that is low for a moment.
void trip(Recovered &exhibit) {
    servo::SafetyLimits limits = servo::unlowered();
    limits.winding_C = 1.0;
    exhibit.session.servo().lower_limits(limits);
    exhibit.pass_until(SafetyState::tripped, 1.0);
    exhibit.session.servo().lower_limits(servo::unlowered());
}

TEST(ExhibitRecovery, ASimulationHealsByItself) {
    Recovered exhibit;
    trip(exhibit);
    exhibit.pass_until(SafetyState::running, 8.0);
    EXPECT_EQ(exhibit.resets, 1);
}

/// The space bar 0.3 s after a fault.
TEST(ExhibitRecovery, AStopDuringAnotherKeepsItOff) {
    Recovered exhibit;
    trip(exhibit);
    exhibit.pass(0.3);
    exhibit.session.servo().emergency_stop();
    exhibit.expect_stays_stopped(180.0);
    EXPECT_EQ(exhibit.said("stopped by hand while it was stopped"), 1);
    EXPECT_EQ(exhibit.resets, 0);
    exhibit.expect_goes_on();
}

/// After its reset, before the motors run again.
TEST(ExhibitRecovery, AStopWhileItHealsKeepsItOff) {
    Recovered exhibit;
    trip(exhibit);
    exhibit.pass_until(SafetyState::starting, 8.0);
    exhibit.session.servo().emergency_stop();
    exhibit.pass(0.1);
    exhibit.expect_stays_stopped(15.0);
    exhibit.expect_goes_on();
}

TEST(ExhibitRecovery, AStopSwitchKeepsABoardOffAfterItsRelease) {
    Recovered exhibit({"stop@4-8"});
    exhibit.pass_until(SafetyState::tripped, 4.0);
    exhibit.pass(0.1);
    exhibit.expect_stays_stopped(12.0);
    exhibit.expect_goes_on();
}

TEST(ExhibitRecovery, AKeyDuringAStopByTheSwitchAndASwitchDuringAStopByAKeyKeepABoardOff) {
    for (const bool key_first : {false, true}) {
        Recovered exhibit({"stop@4-5"});
        if (!key_first) {
            exhibit.pass_until(SafetyState::tripped, 4.0);
        }
        exhibit.session.servo().emergency_stop();
        exhibit.pass(0.1);
        exhibit.expect_stays_stopped(8.0);
        EXPECT_EQ(exhibit.said("stopped by hand while it was stopped"), 1);
        exhibit.expect_goes_on();
    }
}

TEST(ExhibitRecovery, ABoardThatWasLostAndIsThereAgainAsksAPerson) {
    Recovered exhibit({"unplug@4-5"});
    exhibit.pass_until(SafetyState::tripped, 4.0);
    exhibit.pass(0.1);
    EXPECT_EQ(exhibit.recovery.condition(), Condition::lost);
    exhibit.pass(5.0);
    EXPECT_EQ(exhibit.said("the device is there again"), 1);
    exhibit.expect_stays_stopped(12.0);
    exhibit.expect_goes_on();
}

} // namespace
} // namespace springdrive::app::exhibit

// Covers what the window shows of a session: app/demo/{shown_values,tip_inside}.cpp, the trace,
// what is computed for what is switched on, and whether a point is in a solid rather than beside
// it, below an open mesh or in a bowl; app/panels/{scene_message,event_log}.cpp, which message is
// over the scene, what its button does, and what is listed of what has happened.
#include "app/demo/shown_values.h"
#include "app/panels/scene_overlay.h"
#include "app/panels/session_keeper.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/haptic_law.h"
#include "engine/session/telemetry_history.h"
#include "tests/engine/session/session_fixture.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

/// A tip that circles once in 6 s, with a force that grows by 0.1 N/s.
session::TelemetryHistory circled(double servo_hz, double duration_s) {
    session::TelemetryHistory history(testing::phantom_1_0().geometry, servo_hz);
    for (int tick = 0; tick < static_cast<int>(duration_s * servo_hz); ++tick) {
        servo::ServoSample sample;
        sample.time_s = tick / servo_hz;
        sample.tip_m = {0.02 * std::cos(sample.time_s), 0.01, 0.02 * std::sin(sample.time_s)};
        sample.tip_force_N = {0.0, 0.1 * sample.time_s, 0.0};
        history.add(sample);
    }
    return history;
}

TEST(RecentTrace, HoldsTheLastFiveSecondsWithTheirForces) {
    for (const double servo_hz : {1000.0, 250.0, 10'000.0}) {
        const session::TelemetryHistory history = circled(servo_hz, 7.0);
        for (const std::optional<double> &until_s : {std::optional<double>(), std::optional(6.0)}) {
            const double end_s = until_s.value_or(7.0 - 1.0 / servo_hz);
            const auto trace_N = recent_trace(history.store(), until_s);
            EXPECT_NEAR(static_cast<double>(trace_N.size()), 500.0,
                        130.0); // whole rows: 8 to 12 ms
            double before_s = end_s - 5.0 - 0.02;
            for (const PlacedValue &place : trace_N) {
                const double then_s = 10.0 * place.value;
                EXPECT_GT(then_s, before_s);
                EXPECT_LT(then_s, before_s + 0.035);
                EXPECT_LT(
                    (place.at_m - Vector3(0.02 * std::cos(then_s), 0.01, 0.02 * std::sin(then_s)))
                        .norm(),
                    1e-7); // the store keeps floats where they are exact; force and place
                before_s = then_s;
            }
            EXPECT_NEAR(before_s, end_s, 1.0 / servo_hz + 1e-9); // up to where the tip is
        }
    }
}

TEST(RecentTrace, StandsStillWhileItGrows) {
    // The same rows in every frame, or the trace would flicker.
    const auto shorter = recent_trace(circled(1000.0, 6.5).store(), {});
    const auto longer = recent_trace(circled(1000.0, 6.507).store(), {});
    for (std::size_t i = 10; i + 1 < shorter.size(); ++i) { // the last is where the tip was then
        EXPECT_TRUE(std::ranges::any_of(longer, [&](const PlacedValue &place) {
            return place.at_m == shorter[i].at_m;
        })) << i;
    }
    EXPECT_TRUE(recent_trace(circled(1000.0, 0.001).store(), {}).empty());
}

TEST(ShownValues, AreComputedForWhatIsSwitchedOnOnly) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const session::TelemetryHistory history = circled(1000.0, 1.0);
    servo::ServoSample now;
    now.theta_rad = device::motor_from_joint(device.geometry, {0.1, 0.2, -0.1});
    now.tip_m = device::tip_position_m(device.geometry, {0.1, 0.2, -0.1});
    now.contact.touching = true;
    now.contact.normal = Vector3::UnitY();
    now.contact.x0_m = now.tip_m + 0.002 * now.contact.normal;
    now.contact.eta = 0.0;
    now.x_Sd_m = now.contact.x0_m;
    now.alpha_rad2_per_m2 = 5000.0;
    const PlotSubject subject{history.store()};
    ShownValues values;
    const TouchValues &none = values.at(ShownThings(), device, now, subject);
    EXPECT_FALSE(none.set_point_m || none.inverse_force_N || none.transpose_force_N ||
                 none.inverse_stiffness_N_per_m || none.workspace);
    EXPECT_TRUE(none.trace_N.empty());
    ShownThings shown;
    for (const OverlayStyle &look : kThings) {
        shown.show(look.thing, true);
    }
    const TouchValues all = values.at(shown, device, now, subject);
    EXPECT_TRUE(all.set_point_m && all.inverse_force_N && all.transpose_force_N &&
                all.inverse_stiffness_N_per_m && all.workspace && !all.trace_N.empty());
    // Computed once for a device and a tuning, whichever map is in use.
    now.tuning.map = control::MotionMap::inverse;
    EXPECT_EQ(values.at(shown, device, now, subject).workspace, all.workspace);
    now.tuning.K_P_V_per_rad *= 2.0;
    const TouchValues stiffer = values.at(shown, device, now, subject);
    EXPECT_NEAR(stiffer.workspace->largest / all.workspace->largest, 2.0, 1e-9); // (13), (27)
    shown.show(Thing::direction_errors, true);                                   // instead
    EXPECT_LT(values.at(shown, device, now, subject).workspace->largest, 1.6);   // rad
    now.contact.touching = false;
    const TouchValues free = values.at(shown, device, now, subject);
    EXPECT_FALSE(free.set_point_m || free.inverse_force_N || free.transpose_force_N);
    EXPECT_TRUE(free.inverse_stiffness_N_per_m); // in free space, too
}

/// Adds a box; `sides` of its six sides, the last of which is the one below.
void add_box(scene::Scene &scene, const Vector3 &lower_m, const Vector3 &upper_m, int sides = 6) {
    auto &soup = scene.surface;
    const auto first = static_cast<std::uint32_t>(soup.vertices_m.size());
    for (unsigned corner = 0; corner < 8; ++corner) {
        soup.vertices_m.emplace_back((corner & 1U) != 0U ? upper_m.x() : lower_m.x(),
                                     (corner & 2U) != 0U ? upper_m.y() : lower_m.y(),
                                     (corner & 4U) != 0U ? upper_m.z() : lower_m.z());
    }
    // Counter-clockwise from outside: right, left, above, front, back, below.
    constexpr std::array<std::array<std::uint32_t, 4>, 6> kSides{
        {{1, 3, 7, 5}, {0, 4, 6, 2}, {2, 6, 7, 3}, {4, 5, 7, 6}, {0, 2, 3, 1}, {0, 1, 5, 4}}};
    for (int side = 0; side < sides; ++side) {
        const auto &at = kSides[static_cast<std::size_t>(side)];
        soup.triangles.push_back({first + at[0], first + at[1], first + at[2]});
        soup.triangles.push_back({first + at[0], first + at[2], first + at[3]});
    }
    scene.lower_m = scene.lower_m.cwiseMin(lower_m);
    scene.upper_m = scene.upper_m.cwiseMax(upper_m);
}

const Vector3 kLower_m(-0.02, -0.03, -0.01);
const Vector3 kUpper_m(0.04, 0.01, 0.05);

TEST(TipInside, IsToldFromBesideABoxAtRandomAndRoundPlaces) {
    scene::Scene scene;
    add_box(scene, kLower_m, kUpper_m);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(-0.06, 0.06);
    int inside = 0;
    for (int i = 0; i < 2000; ++i) {
        Vector3 point(place(random), place(random), place(random));
        if (i % 2 == 1) { // on the box's diagonals and corners, in parts
            point = (100.0 * point).array().round() / 100.0;
        }
        const double beyond =
            std::max((kLower_m - point).maxCoeff(), (point - kUpper_m).maxCoeff());
        if (std::abs(beyond) < 1e-6) {
            continue; // on the surface
        }
        EXPECT_EQ(lies_inside(scene, point), beyond < 0.0) << point.transpose();
        inside += beyond < 0.0 ? 1 : 0;
    }
    EXPECT_GT(inside, 50);
}

TEST(TipInside, IsFalseInAnOpenBoxAndBelowASheet) {
    scene::Scene open;
    add_box(open, kLower_m, kUpper_m, 5);
    EXPECT_FALSE(lies_inside(open, Vector3::Zero()));
    scene::Scene sheet;
    sheet.surface.vertices_m = {{-0.1, 0.0, -0.1}, {-0.1, 0.0, 0.1}, {0.1, 0.0, 0.1}};
    sheet.surface.triangles = {{0, 1, 2}};
    sheet.lower_m = Vector3::Constant(-0.1);
    sheet.upper_m = Vector3::Constant(0.1);
    for (const double y : {-0.01, 0.01}) {
        EXPECT_FALSE(lies_inside(sheet, {-0.05, y, 0.0}));
    }
}

TEST(TipInside, KnowsHollowsAndOverlaps) {
    scene::Scene scene;
    add_box(scene, kLower_m, kUpper_m);
    add_box(scene, Vector3(0.03, -0.02, 0.0), Vector3(0.08, 0.0, 0.02)); // overlaps the first
    EXPECT_TRUE(lies_inside(scene, {0.035, -0.01, 0.01}));               // in both
    EXPECT_TRUE(lies_inside(scene, {0.06, -0.01, 0.01}));
    scene::Scene hollow;
    add_box(hollow, kLower_m, kUpper_m);
    add_box(hollow, Vector3::Constant(-0.005), Vector3::Constant(0.005));
    for (std::size_t i = 12; i < 24; ++i) { // the walls of a hollow face it
        std::swap(hollow.surface.triangles[i][1], hollow.surface.triangles[i][2]);
    }
    EXPECT_FALSE(lies_inside(hollow, {0.001, 0.002, 0.001}));
    EXPECT_TRUE(lies_inside(hollow, {0.001, -0.01, 0.001}));
}

TEST(TipInside, KnowsSolidShapes) {
    scene::Scene scene;
    scene.shapes.emplace_back(contact::Sphere{0.02},
                              Eigen::Isometry3d(Eigen::Translation3d(0.01, 0.0, 0.0)),
                              std::uint16_t{0});
    EXPECT_TRUE(lies_inside(scene, {0.0299, 0.0, 0.0}));
    EXPECT_FALSE(lies_inside(scene, {0.0301, 0.0, 0.0}));
}

TEST(TipInside, IsComputedAnewForAnotherSceneOrPlaceButNotAllTheTime) {
    scene::Scene box;
    add_box(box, kLower_m, kUpper_m);
    const scene::Scene empty;
    TipInside inside;
    const Vector3 out_m(0.0, 0.1, 0.0);
    EXPECT_TRUE(inside.at(box, 1, Vector3::Zero(), 0.0));
    EXPECT_TRUE(inside.at(box, 1, out_m, 0.1)); // not yet
    EXPECT_FALSE(inside.at(box, 1, out_m, 0.3));
    EXPECT_FALSE(inside.at(box, 1, Vector3::Zero(), 0.4));
    EXPECT_TRUE(inside.at(box, 1, Vector3::Zero(), 0.6));
    EXPECT_FALSE(inside.at(empty, 2, Vector3::Zero(), 0.61)); // at once
    EXPECT_FALSE(inside.at(box, 3, Vector3::Constant(std::nan("")), 0.7));
}

using servo::SafetyState;
using servo::TripCause;

SceneSituation in_state(SafetyState state, TripCause cause = TripCause::none) {
    SceneSituation now;
    now.safety.state = state;
    now.safety.cause = cause;
    return now;
}

TEST(SceneMessages, AreNoneWhileTheDeviceIsReady) {
    for (const SafetyState state :
         {SafetyState::starting, SafetyState::running, SafetyState::releasing}) {
        for (const bool touching : {false, true}) {
            SceneSituation now = in_state(state);
            now.touching = touching;
            EXPECT_FALSE(message_for(now).has_value());
        }
    }
}

TEST(SceneMessages, AreOneAtATimeTheMostImportantFirst) {
    // Each makes its message necessary; the first is the most important.
    const std::vector<std::pair<std::string, std::function<void(SceneSituation &)>>> by_importance{
        {"stopped", [](SceneSituation &now) { now.safety.state = SafetyState::tripped; }},
        {"record shown", [](SceneSituation &now) { now.record = "touch.rec"; }},
        {"paused", [](SceneSituation &now) { now.is_paused = true; }},
        {"waiting", [](SceneSituation &now) { now.is_in_exclusive_use = true; }},
        {"waiting", [](SceneSituation &now) { now.is_released = true; }},
        {"waiting", [](SceneSituation &now) { now.is_zeroed = false; }},
        {"inside", [](SceneSituation &now) { now.is_inside = true; }},
        {"waiting", [](SceneSituation &) {}},
    };
    for (std::size_t first = 0; first < by_importance.size(); ++first) {
        SceneSituation now = in_state(SafetyState::waiting);
        for (std::size_t i = first; i < by_importance.size(); ++i) {
            by_importance[i].second(now);
        }
        const std::optional<SceneMessage> message = message_for(now);
        ASSERT_TRUE(message.has_value()) << first;
        EXPECT_EQ(message->name, by_importance[first].first) << first;
    }
}

TEST(SceneMessages, SayWhatIsTheCaseAndOfferWhatHelps) {
    struct Case {
        const char *what;
        SafetyState state;
        std::function<void(SceneSituation &)> change;
        const char *text; ///< part of it
        SceneAction action;
        const char *more = ""; ///< part of it
    };
    const auto stopped_by = [](TripCause cause, bool is_lost = false, bool reconnects = false) {
        return [=](SceneSituation &now) {
            now.safety.cause = cause;
            now.is_lost = is_lost;
            now.reconnects = reconnects;
        };
    };
    const std::vector<Case> cases{
        {"stop", SafetyState::tripped, stopped_by(TripCause::emergency_stop),
         "Stopped: emergency stop. The motors brake.", SceneAction::reset},
        {"lost", SafetyState::tripped, stopped_by(TripCause::device_lost, true), "Stopped",
         SceneAction::none, "in the tab Plant"},
        {"lost, and comes again", SafetyState::tripped,
         stopped_by(TripCause::device_lost, true, true), "Stopped", SceneAction::none, "by itself"},
        {"there again", SafetyState::tripped, stopped_by(TripCause::device_lost, false, true),
         "Stopped", SceneAction::reset},
        {"assertion", SafetyState::tripped, stopped_by(TripCause::assertion), "Stopped",
         SceneAction::none},
        {"free", SafetyState::waiting, [](SceneSituation &) {}, "held still", SceneAction::none},
        {"touching", SafetyState::waiting, [](SceneSituation &now) { now.touching = true; },
         "Lift the tip to start.", SceneAction::retract_hand},
        {"not zeroed", SafetyState::waiting, [](SceneSituation &now) { now.is_zeroed = false; }, "",
         SceneAction::zero},
        {"released", SafetyState::waiting, [](SceneSituation &now) { now.is_released = true; },
         "The device only brakes.", SceneAction::none},
        {"lent", SafetyState::waiting,
         [](SceneSituation &now) { now.is_released = now.is_in_exclusive_use = true; },
         "its motors may act", SceneAction::none},
        {"inside", SafetyState::waiting, [](SceneSituation &now) { now.is_inside = true; },
         "The tip is inside: pull out.", SceneAction::retract_hand},
        {"inside, running", SafetyState::running, [](SceneSituation &now) { now.is_inside = true; },
         "The tip is inside: pull out.", SceneAction::retract_hand},
        {"hand of others", SafetyState::waiting,
         [](SceneSituation &now) {
             now.touching = true;
             now.can_move_hand = false;
         },
         "Lift", SceneAction::none},
        {"inside by others", SafetyState::waiting,
         [](SceneSituation &now) {
             now.is_inside = true;
             now.can_move_hand = false;
         },
         "inside", SceneAction::none},
        {"record", SafetyState::running, [](SceneSituation &now) { now.record = "touch.rec"; },
         "Record: touch.rec. The servo goes on.", SceneAction::show_present},
        {"record of a scene", SafetyState::running,
         [](SceneSituation &now) {
             now.record = "touch.rec";
             now.scene_of_record = "'bone.glb'";
         },
         "Record: touch.rec", SceneAction::show_present, "'bone.glb'"},
        {"paused", SafetyState::running, [](SceneSituation &now) { now.is_paused = true; }, "",
         SceneAction::go_on},
    };
    for (const Case &one : cases) {
        SceneSituation now = in_state(one.state);
        one.change(now);
        const std::optional<SceneMessage> message = message_for(now);
        ASSERT_TRUE(message.has_value()) << one.what;
        EXPECT_NE(message->text.find(one.text), std::string::npos) << one.what << message->text;
        EXPECT_NE(message->more.find(one.more), std::string::npos) << one.what << message->more;
        EXPECT_EQ(message->action, one.action) << one.what;
        EXPECT_EQ(std::string(message->button).empty(), one.action == SceneAction::none);
    }
    SceneSituation now = in_state(SafetyState::running); // it pushes into another surface, as usual
    now.is_inside = now.touching = true;
    EXPECT_TRUE(!message_for(now) || message_for(now)->name != std::string("inside"));
}

std::size_t count(const EventLog &log, EventLog::Kind kind, const std::string &text) {
    return static_cast<std::size_t>(
        std::ranges::count_if(log.events(), [&](const EventLog::Event &event) {
            return event.kind == kind && event.what.find(text) != std::string::npos;
        }));
}

TEST(EventLog, HoldsEveryTripAlsoOneThatIsResetWithinAFrame) {
    session::Session session(testing::scripted());
    EventLog log;
    testing::run(session, 1.5);
    log.update(session);
    EXPECT_EQ(count(log, EventLog::Kind::note, "scene plate.gltf"), 1U);
    EXPECT_EQ(count(log, EventLog::Kind::note, "motors running"), 1U);
    EXPECT_EQ(count(log, EventLog::Kind::trip, "stopped"), 0U);
    for (int trip = 0; trip < 3; ++trip) {
        session.servo().emergency_stop();
        session.advance(0.004);
        session.advance(0.004);
        session.servo().let_go_on();
        session.advance(0.004);
    }
    log.update(session);
    EXPECT_EQ(count(log, EventLog::Kind::trip, "stopped: emergency stop"), 3U);
    EXPECT_EQ(count(log, EventLog::Kind::note, "reset"), 3U);
    log.update(session); // nothing twice
    EXPECT_EQ(count(log, EventLog::Kind::trip, "stopped"), 3U);
}

TEST(EventLog, HoldsChangesOfTuningRateAndRecord) {
    const std::filesystem::path folder = testing::fresh_folder("event_log");
    session::Session session(testing::scripted());
    EventLog log;
    testing::run(session, 0.1);
    log.update(session);
    control::Tuning other = session.tuning().now();
    other.K_P_V_per_rad = 7.0;
    session.tuning().change(other, session.latest().time_s);
    session.set_servo_rate(2000.0);
    session.start_recording(folder / "t.rec");
    log.update(session);
    session.recording().stop();
    log.update(session);
    EXPECT_EQ(count(log, EventLog::Kind::change, "K_P 6 → 7 V/rad"), 1U);
    EXPECT_EQ(count(log, EventLog::Kind::note, "servo at 2000 Hz"), 1U);
    EXPECT_EQ(count(log, EventLog::Kind::note, "recording to"), 1U);
    EXPECT_EQ(count(log, EventLog::Kind::note, "record ended"), 1U);
    EXPECT_TRUE(std::ranges::is_sorted(log.events(), {}, &EventLog::Event::time_s));
}

} // namespace
} // namespace springdrive::app

// Covers app/exhibit/tour.cpp: the scripted hand in every scene, on the simulated device; and
// app/exhibit/course.cpp, in simulated time.
#include "app/exhibit/course.h"
#include "app/exhibit/tour.h"
#include "app/exhibit/trip_recovery.h"
#include "base/degrees.h"
#include "engine/session/session.h"
#include "engine/session/telemetry_history.h"
#include "tests/engine/session/session_fixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

namespace springdrive::app::exhibit {
namespace {

session::SessionOptions at_an_exhibit(const std::string &scene) {
    session::SessionOptions options = testing::scripted(scene);
    options.plays_script = false;
    return options;
}

std::optional<Showing> showing_in(session::Session &session, const TourStop &stop) {
    const session::LoadedScene &scene = session.scenes().now();
    return showing_of(session.description(), scene.scene, scene.surface, stop.gesture,
                      session.hand().target_m());
}

double largest(const session::Session &session, const std::string &channel) {
    const record::ChannelStore &store = session.servo().history().store();
    return store.extremes(*session::channel_named(channel), store.begin(), store.end()).maximum;
}

TEST(ExhibitTour, HasEveryIncludedSceneOnceWithItsWords) {
    std::set<std::string> included;
    for (const auto &file : std::filesystem::directory_iterator(testing::assets() / "scenes")) {
        if (file.path().extension() == ".gltf") {
            included.insert(file.path().stem().string());
        }
    }
    std::set<std::string> shown;
    for (const TourStop &stop : kTour) {
        EXPECT_TRUE(shown.emplace(stop.scene).second) << stop.scene;
        EXPECT_TRUE(std::filesystem::exists(file_of(stop))) << stop.scene;
    }
    EXPECT_EQ(shown, included);
}

class ExhibitTourIn : public ::testing::TestWithParam<TourStop> {};

TEST_P(ExhibitTourIn, IsTouchedByTheScriptedHandWithoutAStop) {
    const TourStop &stop = GetParam();
    session::Session session(at_an_exhibit(std::string(stop.scene)));
    session.servo().lower_limits(kiosk_limits());
    session.start();
    testing::run(session, 1.5);
    ASSERT_EQ(session.latest().safety.state, servo::SafetyState::running);
    const scene::Scene &scene = session.scenes().now().scene;
    EXPECT_FALSE(sentence_of(stop, scene).empty());
    const std::optional<Showing> showing = showing_in(session, stop);
    ASSERT_TRUE(showing);
    const auto &points = showing->path.points();
    for (std::size_t i = 1; i < points.size(); ++i) {
        const double way_m = (points[i].position_m - points[i - 1].position_m).norm();
        EXPECT_LE(way_m / (points[i].time_s - points[i - 1].time_s), kStrike_m_per_s + 1e-9);
    }
    EXPECT_LT(showing->path.end_s(), 30.0);
    session.follow_path(showing->path);
    double touched_s = 0.0;
    while (session.hand().follows_path()) {
        session.advance(testing::kFrame_s);
        touched_s += session.latest().contact.touching ? testing::kFrame_s : 0.0;
        ASSERT_EQ(session.latest().safety.state, servo::SafetyState::running)
            << servo::description(session.latest().safety);
    }
    EXPECT_GT(touched_s, 1.0);
    EXPECT_GT(largest(session, "force_N"), 0.7);
    EXPECT_LT(largest(session, "force_N"), kiosk_limits().tip_force_N);
    EXPECT_FALSE(session.latest().contact.touching); // for the visitor
}

INSTANTIATE_TEST_SUITE_P(Scenes, ExhibitTourIn, ::testing::ValuesIn(kTour),
                         [](const auto &each) { return std::string(each.param.scene); });

TEST(ExhibitTour, ShowsBothMapsWhereTheyDiffer) {
    const TourStop &stop = kTour[1];
    session::Session session(at_an_exhibit(std::string(stop.scene)));
    session.servo().lower_limits(kiosk_limits());
    session.start();
    testing::run(session, 1.5);
    const std::optional<Showing> showing = showing_in(session, stop);
    ASSERT_TRUE(showing);
    ASSERT_EQ(showing->switches_s.size(), 2U);
    session.follow_path(showing->path);
    std::vector<double> angle_deg;
    const double begin_s = session.latest().time_s;
    for (const double switch_s : showing->switches_s) {
        while (session.latest().time_s - begin_s < switch_s) {
            session.advance(testing::kFrame_s);
        }
        angle_deg.push_back(kDegreesPerRadian * session.latest().rendered_error_rad);
        control::Tuning tuning = session.latest().tuning;
        tuning.map = tuning.map == control::MotionMap::inverse ? control::MotionMap::transpose
                                                               : control::MotionMap::inverse;
        session.tuning().change(tuning, session.plot_time_s());
    }
    EXPECT_LT(angle_deg[0], 5.0);  // transpose
    EXPECT_GT(angle_deg[1], 25.0); // inverse: the limit of perception
}

/// Out from below the plate of a millimetre, where straight up is no way.
TEST(ExhibitTour, FindsTheWayOutFromBelow) {
    session::Session session(at_an_exhibit("thin_plate"));
    session.start();
    const scene::Scene &scene = session.scenes().now().scene;
    const Vector3 below_m(0.5 * (scene.lower_m.x() + scene.upper_m.x()), scene.lower_m.y() - 0.01,
                          scene.upper_m.z() - 0.01);
    ASSERT_TRUE(device::can_reach(session.description(), below_m));
    // Round its edge to there.
    const Vector3 beside_m(below_m.x(), below_m.y(), scene.upper_m.z() + 0.015);
    testing::run(session, 1.5);
    session.hand().move_to({beside_m.x(), session.hand().target_m().y(), beside_m.z()});
    testing::run(session, 1.0);
    session.hand().move_to(beside_m);
    testing::run(session, 1.0);
    session.hand().move_to(below_m);
    testing::run(session, 1.0);
    ASSERT_LT(session.latest().tip_m.y(), scene.lower_m.y());
    const auto showing = showing_of(session.description(), scene, session.scenes().now().surface,
                                    Gesture::stroke, session.hand().target_m());
    ASSERT_TRUE(showing);
    session.follow_path(showing->path);
    while (session.hand().follows_path() && session.latest().tip_m.y() <= scene.upper_m.y()) {
        session.advance(testing::kFrame_s);
        EXPECT_FALSE(session.latest().contact.touching);
    }
    EXPECT_GT(session.latest().tip_m.y(), scene.upper_m.y());
}

constexpr double kFrame_s = 0.1;
constexpr double kLittle_s = 0.01;

/// A course with its clock, and a scripted hand that takes a given time.
class Walk {
public:
    explicit Walk(std::size_t scenes = 3) : course(scenes) { step({}); }

    CourseOrders step(CourseNow now, double frame_s = kFrame_s) {
        time_s += frame_s;
        now.time_s = time_s;
        return course.update(now);
    }
    /// Ready, and nobody touches anything.
    CourseOrders wait(double seconds, bool is_ready = true) {
        CourseOrders all;
        const double end_s = time_s + seconds;
        while (time_s < end_s - 1e-9) {
            const CourseOrders one =
                step({.is_ready = is_ready}, std::min(kFrame_s, end_s - time_s));
            all.scene = one.scene ? one.scene : all.scene;
            all.resets = all.resets || one.resets;
            all.performs = all.performs || one.performs;
            all.leaves = all.leaves || one.leaves;
        }
        return all;
    }
    CourseOrders touch() { return step({.is_touched = true, .is_ready = true}); }
    CourseOrders end_show() { return step({.is_ready = true, .is_shown = true}); }
    /// A visit in the visitor's turn, just touched.
    void go_to_your_turn() {
        touch();
        wait(kFrame_s);
        end_show();
        EXPECT_EQ(course.stage(), Stage::your_turn);
    }

    Course course;
    double time_s = 0.0;
};

TEST(ExhibitCourse, AttractsFromSceneToSceneForever) {
    Walk walk;
    for (std::size_t round = 0; round < 7; ++round) {
        EXPECT_EQ(walk.course.scene(), round % 3);
        EXPECT_TRUE(walk.wait(kFrame_s).performs);
        EXPECT_FALSE(walk.wait(100.0).performs); // as long as it takes
        EXPECT_FALSE(walk.end_show().scene);
        EXPECT_FALSE(walk.wait(Course::kBetween_s - kLittle_s).scene);
        EXPECT_EQ(walk.wait(2.0 * kLittle_s).scene, (round + 1) % 3);
    }
    EXPECT_EQ(walk.course.stage(), Stage::attract);
    EXPECT_EQ(walk.course.visitors(), 0U);
}

TEST(ExhibitCourse, ATouchBeginsAVisitFromTheFirstScene) {
    Walk walk;
    walk.wait(kFrame_s);
    walk.end_show();
    walk.wait(Course::kBetween_s + kFrame_s);
    ASSERT_EQ(walk.course.scene(), 1U);
    ASSERT_TRUE(walk.course.is_performing());
    const CourseOrders orders = walk.touch();
    EXPECT_TRUE(orders.visit_begins);
    EXPECT_TRUE(orders.resets);
    EXPECT_TRUE(orders.leaves);
    EXPECT_EQ(orders.scene, 0U);
    EXPECT_EQ(walk.course.stage(), Stage::showing);
    EXPECT_EQ(walk.course.visitors(), 1U);
}

TEST(ExhibitCourse, ShowsThenLeavesTheHandToTheVisitor) {
    Walk walk;
    walk.touch();
    EXPECT_FALSE(walk.wait(1.0, false).performs); // while it is not ready
    EXPECT_TRUE(walk.wait(kFrame_s).performs);
    walk.wait(30.0);
    EXPECT_EQ(walk.course.stage(), Stage::showing);
    EXPECT_FALSE(walk.end_show().leaves); // it is at its end
    EXPECT_EQ(walk.course.stage(), Stage::your_turn);
}

TEST(ExhibitCourse, TheVisitorMayTakeTheHandEarlier) {
    Walk walk;
    walk.touch();
    walk.wait(1.0);
    walk.touch(); // is not enough
    EXPECT_EQ(walk.course.stage(), Stage::showing);
    EXPECT_TRUE(walk.step({.is_touched = true, .takes_hand = true, .is_ready = true}).leaves);
    EXPECT_EQ(walk.course.stage(), Stage::your_turn);
}

TEST(ExhibitCourse, ASceneThatDoesNotGetReadyIsNotWaitedForForever) {
    Walk walk;
    walk.wait(Course::kLoadTimeout_s - 2.0 * kFrame_s, false);
    EXPECT_EQ(walk.course.scene(), 0U);
    walk.wait(3.0 * kFrame_s, false);
    EXPECT_EQ(walk.course.scene(), 1U);
    EXPECT_TRUE(walk.wait(kFrame_s).performs);
    walk.touch();
    walk.wait(Course::kLoadTimeout_s - kLittle_s, false);
    EXPECT_EQ(walk.course.stage(), Stage::showing);
    walk.wait(2.0 * kLittle_s, false);
    EXPECT_EQ(walk.course.stage(), Stage::your_turn);
}

TEST(ExhibitCourse, AStopEndsTheShowAndItBeginsAnew) {
    Walk walk;
    walk.touch();
    walk.wait(5.0);
    EXPECT_TRUE(walk.wait(kFrame_s, false).leaves);
    EXPECT_FALSE(walk.course.is_performing());
    walk.wait(Course::kLoadTimeout_s - 2.0 * kFrame_s, false);
    EXPECT_EQ(walk.course.stage(), Stage::showing); // the patience began with the stop
    EXPECT_TRUE(walk.wait(kFrame_s).performs);
}

TEST(ExhibitCourse, AsksWhetherSomebodyIsThereAndThenAttractsAgain) {
    Walk walk;
    walk.go_to_your_turn();
    walk.wait(Course::kIdle_s - kLittle_s);
    EXPECT_FALSE(walk.course.leaves_in_s());
    walk.wait(2.0 * kLittle_s);
    ASSERT_TRUE(walk.course.leaves_in_s());
    EXPECT_NEAR(*walk.course.leaves_in_s(), Course::kIdlePrompt_s, 2.0 * kLittle_s);
    walk.wait(Course::kIdlePrompt_s - 3.0 * kLittle_s);
    walk.touch(); // in the last moment
    EXPECT_FALSE(walk.course.leaves_in_s());
    walk.wait(Course::kIdle_s + Course::kIdlePrompt_s - kLittle_s);
    EXPECT_EQ(walk.course.stage(), Stage::your_turn);
    const CourseOrders orders = walk.wait(3.0 * kLittle_s);
    EXPECT_EQ(walk.course.stage(), Stage::attract);
    EXPECT_TRUE(orders.resets);
    EXPECT_EQ(orders.scene, 0U);
    EXPECT_EQ(walk.course.visitors(), 1U);
}

TEST(ExhibitCourse, GoesToTheNextSceneAndRoundAgain) {
    Walk walk;
    walk.go_to_your_turn();
    const CourseNow next{.is_touched = true, .next_scene = true};
    for (const std::size_t scene : {1U, 2U, 0U, 1U}) { // from your turn, then from showing
        const CourseOrders orders = walk.step(next);
        EXPECT_EQ(orders.scene, scene);
        EXPECT_FALSE(orders.resets);
        EXPECT_EQ(walk.course.stage(), Stage::showing);
    }
}

TEST(ExhibitCourse, TheNextVisitorBeginsInAnyStage) {
    const CourseNow next{.is_touched = true, .next_visitor = true};
    Walk walk;
    for (std::size_t visitor = 1; visitor <= 3; ++visitor) {
        const CourseOrders orders = walk.step(next);
        EXPECT_TRUE(orders.resets && orders.visit_begins);
        EXPECT_EQ(orders.scene, 0U);
        EXPECT_EQ(walk.course.visitors(), visitor);
        if (visitor == 2) {
            walk.wait(kFrame_s);
            walk.end_show(); // the third comes in the visitor's turn
        }
    }
}

TEST(ExhibitCourse, AfterASleepItAttractsWithoutABurst) {
    Walk walk;
    walk.go_to_your_turn();
    EXPECT_EQ(walk.step({}, Course::kGap_s - kLittle_s).gap_s, 0.0);
    EXPECT_EQ(walk.course.stage(), Stage::your_turn);
    constexpr double kNight_s = 12.0 * 3600.0;
    // Touched by what was done before the sleep.
    const CourseOrders orders = walk.step({.is_touched = true}, kNight_s);
    EXPECT_EQ(orders.gap_s, kNight_s);
    EXPECT_TRUE(orders.resets);
    EXPECT_EQ(orders.scene, 0U);
    EXPECT_EQ(walk.course.stage(), Stage::attract);
    EXPECT_EQ(walk.course.visitors(), 1U); // one frame, one step
    EXPECT_EQ(walk.step({}).gap_s, 0.0);
    Course first(3); // however long the computer has run before
    EXPECT_EQ(first.update({.time_s = 1e6}).gap_s, 0.0);
    EXPECT_EQ(first.scene(), 0U);
}

} // namespace
} // namespace springdrive::app::exhibit

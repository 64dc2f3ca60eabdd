// Covers the steps of app/assistant on an emulated device: healthy to the end, and with faults.
#include "app/assistant/findings.h"
#include "tests/app/assistant/walker.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace springdrive::app::assistant {
namespace {

using testing::Walker;

TEST(AssistantWalk, LeadsAHealthyDeviceToItsFirstTouch) {
    const std::filesystem::path folder = testing::fresh_folder("assistant_walk");
    Walker walker({}, folder);
    ASSERT_TRUE(walker.assistant.is_open()); // at the first connection
    const control::Tuning before = walker.session.servo().inputs().tuning;
    walker.walk_to(StepName::touch);
    EXPECT_TRUE(walker.session.is_zeroed());
    walker.run(0.5);
    constexpr double kGentle_N = 1.0;
    EXPECT_EQ(walker.session.latest().limits.tip_force_N, kGentle_N);
    walker.touch();
    EXPECT_EQ(walker.verdict(), Verdict::good) << walker.text();
    EXPECT_EQ(walker.session.latest().safety.cause, servo::TripCause::none);
    walker.next();
    EXPECT_FALSE(walker.assistant.is_open());
    EXPECT_TRUE(walker.assistant.is_complete());
    EXPECT_TRUE(read_progress(folder / progress_name("emulated", "emulated")).done.all());
    EXPECT_FALSE(walker.session.is_kept_released());
    EXPECT_EQ(walker.session.servo().inputs().tuning, before);
    EXPECT_EQ(walker.session.servo().inputs().limits.tip_force_N, servo::unlowered().tip_force_N);
    std::filesystem::remove_all(folder);
}

TEST(AssistantWalk, DrivesNoMotorBeforeTheTouch) {
    Walker walker;
    const auto is_driven = [&] { return servo::lets_pass(walker.session.latest().safety.state); };
    bool was_driven = false;
    const auto watch = [&] {
        was_driven = was_driven || is_driven();
        return false;
    };
    walker.walk_to(StepName::self_test);
    walker.run_until(watch, 3.0); // zeroed, and held still in free space
    EXPECT_FALSE(was_driven);
    walker.assistant.leave(walker.session);
    EXPECT_TRUE(walker.run_until(is_driven, 3.0)); // normal waiting
    walker.assistant.open(walker.session);
    EXPECT_EQ(walker.assistant.present(), StepName::self_test);
    walker.run(1.0);
    EXPECT_FALSE(is_driven());
}

TEST(AssistantWalk, AMirroredPictureIsNamedAndNotPassed) {
    Walker walker({"reversed-encoder:1"});
    walker.walk_to(StepName::motion);
    walker.choose(Walker::kByHand);
    walker.run(2.0);
    EXPECT_TRUE(walker.says("the picture moved to the left")) << walker.text(); // it went right
    walker.choose("no, the other way");
    walker.run(0.1);
    EXPECT_EQ(walker.verdict(), Verdict::bad);
    EXPECT_TRUE(walker.says("channel 1 is mirrored")) << walker.text();
    EXPECT_FALSE(walker.assistant.can_go_on(walker.session));
    walker.assistant.again(walker.session);
    EXPECT_EQ(walker.verdict(), Verdict::open);
    walker.assistant.leave(walker.session);
    EXPECT_NE(walker.assistant.holds_back(), "");
    EXPECT_TRUE(walker.session.is_kept_released());
}

TEST(AssistantWalk, CrossedEncodersAreNamedByWhatMovedInstead) {
    Walker walker({"crossed-encoders:1:3"});
    walker.walk_to(StepName::motion);
    walker.choose(Walker::kByHand);
    walker.run(2.0);
    EXPECT_TRUE(walker.says("moved another joint, the forearm (joint 3)")) << walker.text();
    EXPECT_FALSE(walker.offers("yes, the same way"));
    walker.choose("no, another joint");
    walker.run(0.1);
    EXPECT_EQ(walker.verdict(), Verdict::bad);
    EXPECT_TRUE(walker.says("exchange the plugs of encoders 1 and 3")) << walker.text();
}

TEST(AssistantWalk, AStopSaysWhatToDoAndNotToGoOn) {
    Walker walker({"failed-sensor:2"});
    walker.run(3.0);
    EXPECT_FALSE(walker.assistant.can_go_on(walker.session));
    EXPECT_TRUE(walker.says("look at the plugs and the supply of the current sensors"))
        << walker.text();
    EXPECT_FALSE(walker.says("Press Next")) << walker.text();
}

struct Damage {
    std::vector<std::string> faults;
    Verdict verdict;
    const char *says; ///< of what is named
};

class AssistantFinds : public ::testing::TestWithParam<Damage> {};

/// By a person who confirms every motion.
TEST_P(AssistantFinds, InItsSelfTestWhatTheEmulatorBroke) {
    const Damage &damage = GetParam();
    Walker walker(damage.faults);
    walker.walk_to(StepName::motion);
    walker.run(0.1);
    for (int joint = 0; joint < 3; ++joint) {
        walker.choose(Walker::kByHand);
        walker.run_until([&] { return !walker.session.hand().follows_path(); }, 10.0);
        walker.choose("yes, the same way");
    }
    walker.next();
    walker.zero();
    walker.next();
    walker.test();
    EXPECT_EQ(walker.verdict(), damage.verdict) << walker.text();
    EXPECT_TRUE(walker.says(damage.says)) << walker.text();
    EXPECT_FALSE(walker.assistant.can_go_on(walker.session));
    walker.assistant.continue_all_the_same(walker.session);
    const bool is_passed = walker.assistant.present() == StepName::calibration;
    EXPECT_EQ(is_passed, damage.verdict == Verdict::doubtful);
    walker.assistant.leave(walker.session);
    EXPECT_EQ(walker.session.is_kept_released(), damage.verdict == Verdict::bad);
}

INSTANTIATE_TEST_SUITE_P(
    Faults, AssistantFinds,
    ::testing::Values(
        Damage{{"reversed-encoder:1"}, Verdict::bad, "encoder 1 counts down"},
        Damage{{"open-winding:2"}, Verdict::bad, "motor 2 draws hardly any current"},
        Damage{{"lost-counts:2:0.1"}, Verdict::bad, "counts are lost"},
        Damage{{"reversed-sensor:3"}, Verdict::bad, "the current sensor of motor 3 counts against"},
        Damage{
            {"sensor-gain:1:1.1"}, Verdict::doubtful, "the current sensor of motor 1 has a gain"}),
    [](const auto &damage) {
        std::string name = damage.param.faults.front();
        std::erase_if(name, [](char letter) { return !std::isalnum(letter); });
        return name;
    });

TEST(AssistantWalk, FindsAZeroThatWasSetElsewhere) {
    Walker walker;
    walker.walk_to(StepName::zeroing);
    walker.session.hand().move_to({0.025, 0.0, 0.0}); // 10° of the base
    walker.run(2.0);
    walker.choose("zero here");
    walker.next();
    walker.test();
    EXPECT_EQ(walker.verdict(), Verdict::bad);
    EXPECT_TRUE(walker.says("the zero of joint 1 is off by")) << walker.text();
    // Back, zeroed in the right place, and tested again:
    walker.assistant.back(walker.session);
    EXPECT_EQ(walker.assistant.present(), StepName::zeroing);
    walker.zero();
    walker.next();
    walker.test();
    EXPECT_EQ(walker.verdict(), Verdict::good) << walker.text();
}

TEST(AssistantWalk, AZeroingAgainVoidsTheSelfTest) {
    Walker walker;
    walker.walk_to(StepName::calibration);
    walker.assistant.go_to(walker.session, StepName::zeroing);
    EXPECT_EQ(walker.assistant.state(StepName::self_test), StepState::done);
    walker.zero();
    walker.run(0.1);
    EXPECT_EQ(walker.assistant.state(StepName::self_test), StepState::open);
}

TEST(AssistantWalk, APulledCableIsNamedAndTheStepGoesOnAfterwards) {
    Walker walker;
    walker.walk_to(StepName::self_test);
    walker.choose("start");
    walker.run(1.5);
    ASSERT_TRUE(walker.session.is_lent());
    walker.session.device().emulated()->set_plugged(false); // in lockstep nobody else uses it
    ASSERT_TRUE(walker.run_until([&] { return !walker.session.is_lent(); }, 5.0));
    walker.run(1.0);
    EXPECT_TRUE(walker.says("the device is lost")) << walker.text();
    EXPECT_FALSE(walker.assistant.can_go_on(walker.session));
    walker.session.device().emulated()->set_plugged(true);
    walker.run(1.5);
    EXPECT_TRUE(walker.session.is_zeroed());
    EXPECT_EQ(walker.assistant.state(StepName::zeroing), StepState::done);
    walker.assistant.again(walker.session);
    walker.run(0.2);
    walker.test();
    EXPECT_EQ(walker.verdict(), Verdict::good) << walker.text();
}

TEST(AssistantWalk, AnEmergencyStopEndsTheSelfTest) {
    Walker walker;
    walker.walk_to(StepName::self_test);
    walker.choose("start");
    walker.run(1.5);
    walker.session.servo().emergency_stop();
    walker.run(0.2);
    EXPECT_FALSE(walker.session.is_lent());
    EXPECT_TRUE(walker.says("emergency stop")) << walker.text();
    EXPECT_FALSE(walker.offers("start"));
    walker.assistant.again(walker.session);
    walker.run(0.2);
    EXPECT_EQ(walker.session.latest().safety.state, servo::SafetyState::waiting);
    EXPECT_TRUE(walker.offers("start"));
}

TEST(AssistantWalk, ALossyConnectionIsDoubtful) {
    Walker walker({"drop:in:0.02"});
    EXPECT_TRUE(walker.run_until([&] { return walker.verdict() == Verdict::doubtful; }, 5.0));
    EXPECT_TRUE(walker.says("did not arrive whole")) << walker.text();
    walker.assistant.continue_all_the_same(walker.session);
    EXPECT_EQ(walker.assistant.present(), StepName::identity);
}

TEST(AssistantWalk, APressedStopSwitchIsNamed) {
    Walker walker({"stop@1-4"});
    walker.run(2.0);
    EXPECT_TRUE(walker.says("stop switch")) << walker.text();
    EXPECT_FALSE(walker.assistant.can_go_on(walker.session));
    walker.run(2.5);
    walker.assistant.again(walker.session);
    walker.next();
    EXPECT_EQ(walker.assistant.present(), StepName::identity);
}

TEST(SelfTestVerdict, OnlyWhatLeavesTheForceInItsDirectionMayBePassed) {
    using commissioning::Problem;
    for (const Problem problem :
         {Problem::reversed_encoder, Problem::reversed_sensor, Problem::crossed_sensors,
          Problem::crossed_encoders, Problem::wrong_zero, Problem::open_winding,
          Problem::dead_encoder, Problem::wrong_counts, Problem::seized_joint, Problem::board_fault,
          Problem::test_aborted}) {
        EXPECT_EQ(unchecked_by(problem), "");
    }
    for (const Problem problem :
         {Problem::stops_not_reached, Problem::wrong_inductance, Problem::wrong_sensor_gain}) {
        EXPECT_NE(unchecked_by(problem), "");
    }
}

} // namespace
} // namespace springdrive::app::assistant

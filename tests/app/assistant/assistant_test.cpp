// Covers app/assistant/assistant.cpp: the sequence of steps, whatever they are, and the file by
// which it is resumed; the steps on an emulated device, healthy to the end and with faults; and
// what findings may be passed.
#include "app/assistant/assistant.h"
#include "base/input_error.h"
#include "tests/app/assistant/walker.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <tuple>
#include <vector>

namespace springdrive::app::assistant {
namespace {

struct Told {
    Verdict verdict = Verdict::open;
    int begun = 0;
    int ended = 0;
};

/// Does as the test says.
class ToldStep final : public Step {
public:
    ToldStep(session::Session &session, Told &told) : Step(session), told_(told) { ++told.begun; }
    void end() override { ++told_.ended; }
    [[nodiscard]] StepReport report() override {
        StepReport report;
        report.verdict = told_.verdict;
        return report;
    }

private:
    Told &told_;
};

class Sequence {
public:
    explicit Sequence(const std::filesystem::path &folder = {})
        : session(testing::Walker::options_with({})), assistant(folder, told_steps()) {
        assistant.update(session);
    }

    void update() { assistant.update(session); }
    void pass(std::size_t step, Verdict verdict = Verdict::good) {
        steps[step].verdict = verdict;
        update();
        assistant.next(session);
    }

    std::array<Told, kSteps> steps{};
    session::Session session;
    Assistant assistant;

private:
    Assistant::Steps told_steps() {
        Assistant::Steps all;
        for (std::size_t i = 0; i < kSteps; ++i) {
            all[i] = [&told = steps[i]](session::Session &of) {
                return std::make_unique<ToldStep>(of, told);
            };
        }
        return all;
    }
};

std::filesystem::path file_in(const std::filesystem::path &folder) {
    return folder / progress_name("emulated", "emulated");
}

TEST(Assistant, OpensForADeviceThatItHasNotSeenYet) {
    Sequence sequence;
    EXPECT_TRUE(sequence.assistant.is_open());
    EXPECT_EQ(sequence.assistant.present(), StepName::link);
    EXPECT_TRUE(sequence.session.is_kept_released());
    session::SessionOptions plain = testing::Walker::options_with({});
    plain.device.kind = factory::DeviceKind::simulated;
    session::Session session(plain);
    Assistant assistant({});
    assistant.update(session);
    EXPECT_FALSE(assistant.is_open());
    assistant.open(session); // by a button
    EXPECT_TRUE(assistant.is_open());
    EXPECT_FALSE(assistant.can_go_on(session));
}

TEST(Assistant, GoesOnOnlyAfterAGoodOrSkippedStepOrIfAskedAfterADoubtfulOne) {
    Sequence sequence;
    for (const Verdict verdict : {Verdict::open, Verdict::doubtful, Verdict::bad}) {
        sequence.pass(0, verdict);
        EXPECT_EQ(sequence.assistant.present(), StepName::link);
    }
    sequence.assistant.continue_all_the_same(sequence.session); // of a bad one
    EXPECT_EQ(sequence.assistant.present(), StepName::link);
    sequence.pass(0, Verdict::skipped);
    EXPECT_EQ(sequence.assistant.present(), StepName::identity);
    EXPECT_EQ(sequence.assistant.state(StepName::link), StepState::done);
    EXPECT_EQ(sequence.assistant.state(StepName::identity), StepState::present);
    EXPECT_EQ(sequence.assistant.state(StepName::motion), StepState::open);
    EXPECT_EQ(sequence.steps[0].ended, 1);
    EXPECT_EQ(sequence.steps[1].begun, 1);
    sequence.steps[1].verdict = Verdict::doubtful;
    sequence.update();
    sequence.assistant.continue_all_the_same(sequence.session);
    EXPECT_EQ(sequence.assistant.present(), StepName::motion);
}

TEST(Assistant, GoesBackAndAgainAndForthOverWhatIsDone) {
    Sequence sequence;
    sequence.assistant.back(sequence.session); // there is none
    EXPECT_EQ(sequence.assistant.present(), StepName::link);
    sequence.pass(0);
    sequence.pass(1);
    sequence.assistant.back(sequence.session);
    EXPECT_EQ(sequence.assistant.present(), StepName::identity);
    EXPECT_EQ(sequence.steps[1].begun, 2);
    sequence.assistant.again(sequence.session);
    EXPECT_EQ(sequence.steps[1].begun, 3);
    sequence.steps[1].verdict = Verdict::open; // not yet seen again, but done before
    sequence.update();
    EXPECT_TRUE(sequence.assistant.can_go_on(sequence.session));
    EXPECT_TRUE(sequence.assistant.can_go_to(StepName::motion)); // the first that is not done
    EXPECT_FALSE(sequence.assistant.can_go_to(StepName::zeroing));
    sequence.assistant.go_to(sequence.session, StepName::zeroing);
    EXPECT_EQ(sequence.assistant.present(), StepName::identity);
    sequence.assistant.go_to(sequence.session, StepName::link);
    EXPECT_EQ(sequence.assistant.present(), StepName::link);
}

TEST(Assistant, AStepThatFailsVoidsWhatCameAfterAndHoldsTheDevice) {
    const std::filesystem::path folder = testing::fresh_folder("assistant_fails");
    {
        Sequence sequence(folder);
        sequence.pass(0);
        sequence.pass(1);
        sequence.assistant.back(sequence.session);
        sequence.steps[1].verdict = Verdict::bad;
        sequence.update();
        EXPECT_FALSE(sequence.assistant.can_go_to(StepName::motion));
        sequence.steps[1].verdict = Verdict::open; // begun again, but not repaired yet
        sequence.update();
        sequence.assistant.leave(sequence.session);
        EXPECT_EQ(sequence.assistant.state(StepName::identity), StepState::failed);
        EXPECT_EQ(sequence.assistant.holds_back(), "Identity");
        EXPECT_TRUE(sequence.session.is_kept_released());
    }
    Sequence later(folder);
    EXPECT_EQ(later.assistant.present(), StepName::identity);
    later.assistant.leave(later.session);
    EXPECT_TRUE(later.session.is_kept_released());
    later.assistant.open(later.session);
    later.pass(1);
    later.assistant.leave(later.session);
    EXPECT_FALSE(later.session.is_kept_released());
}

TEST(Assistant, IsResumedAtTheFirstStepThatIsNotDone) {
    const std::filesystem::path folder = testing::fresh_folder("assistant_resumed");
    {
        Sequence sequence(folder);
        sequence.pass(0);
        sequence.pass(1);
        sequence.assistant.leave(sequence.session);
        EXPECT_FALSE(sequence.assistant.is_open());
        EXPECT_EQ(sequence.steps[2].ended, 1);
        sequence.assistant.open(sequence.session);
        EXPECT_EQ(sequence.assistant.present(), StepName::motion);
    }
    Sequence later(folder);
    EXPECT_TRUE(later.assistant.is_open());
    EXPECT_EQ(later.assistant.present(), StepName::motion);
    for (std::size_t i = 2; i < kSteps; ++i) {
        if (i == index_of(StepName::self_test)) {
            later.session.zero_device(Vector3::Zero());
        }
        later.pass(i);
    }
    EXPECT_FALSE(later.assistant.is_open());
    Sequence last(folder);
    last.session.zero_device(Vector3::Zero());
    EXPECT_FALSE(last.assistant.is_open()); // once is enough
    last.assistant.open(last.session);
    EXPECT_TRUE(last.assistant.is_complete());
}

TEST(Assistant, WithoutItsZeroADeviceIsZeroedAgain) {
    const std::filesystem::path folder = testing::fresh_folder("assistant_zero");
    Progress known;
    known.done.set(); // of a board that has lost its power since
    write_progress(file_in(folder), known);
    Sequence sequence(folder);
    EXPECT_FALSE(sequence.assistant.is_open());
    sequence.assistant.open(sequence.session);
    EXPECT_EQ(sequence.assistant.present(), StepName::zeroing);
}

TEST(Assistant, SaysThatAFileIsDamagedOrCannotBeKeptAndGoesOn) {
    const std::filesystem::path folder = testing::fresh_folder("assistant_damaged");
    std::ofstream(file_in(folder)) << "done = [\"link\",\n  \"nonsense\"]\nfailed = []\n";
    Sequence damaged(folder);
    EXPECT_EQ(damaged.assistant.present(), StepName::link);
    EXPECT_NE(damaged.assistant.error().find(":1: done has 'nonsense'"), std::string::npos)
        << damaged.assistant.error();
    damaged.pass(0);
    EXPECT_EQ(damaged.assistant.error(), "");
    EXPECT_TRUE(read_progress(file_in(folder)).done.test(0));

    Sequence unwritable(file_in(folder)); // which is no folder
    unwritable.pass(0);
    EXPECT_EQ(unwritable.assistant.present(), StepName::identity);
    EXPECT_NE(unwritable.assistant.error(), "");
}

TEST(ProgressFile, HasEveryStepAndRefusesWhatIsNone) {
    const std::filesystem::path file = testing::fresh_folder("progress_file") / "below" / "device";
    EXPECT_EQ(read_progress(file), Progress());
    for (std::size_t i = 0; i < kSteps; ++i) {
        Progress progress;
        progress.done.set(i);
        progress.failed.set(kSteps - 1 - i);
        write_progress(file, progress);
        EXPECT_EQ(read_progress(file), progress);
    }
    for (const char *text : {"", "done = [\"link\"]\n", "done = []\nfailed = [1]\n",
                             "done = []\nfailed = []\nskipped = []\n", "\xff\xfe"}) {
        std::ofstream(file) << text;
        EXPECT_NE(error_text_of([&] { static_cast<void>(read_progress(file)); }), "") << text;
    }
    EXPECT_EQ(progress_name("USB", "A-12_b"), "USB-A-12_b.toml");
    EXPECT_EQ(progress_name("USB", "../x"), "USB-%2e%2e%2fx.toml"); // a file name all the same
    EXPECT_NE(progress_name("USB", "1"), progress_name("emulated", "1"));
}

using commissioning::CalibrationProblem;
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

TEST(AssistantWalk, APictureThatMovesWronglyIsNamedAndNotPassed) {
    struct Case {
        const char *fault;
        const char *shown; ///< beside the question
        const char *answer;
        const char *named;
        bool has_moved; ///< the joint that was asked for, by its own encoder
    };
    for (const Case &one :
         {Case{"reversed-encoder:1", "the picture moved to the left", "no, the other way",
               "channel 1 is mirrored", true}, // it went right
          Case{"crossed-encoders:1:3", "moved another joint, the forearm (joint 3)",
               "no, another joint", "exchange the plugs of encoders 1 and 3", false}}) {
        SCOPED_TRACE(one.fault);
        Walker walker({one.fault});
        walker.walk_to(StepName::motion);
        walker.choose(Walker::kByHand);
        walker.run(2.0);
        EXPECT_TRUE(walker.says(one.shown)) << walker.text();
        EXPECT_EQ(walker.offers("yes, the same way"), one.has_moved);
        EXPECT_EQ(walker.offers("no, the other way"), one.has_moved);
        walker.choose(one.answer);
        walker.run(0.1);
        EXPECT_EQ(walker.verdict(), Verdict::bad);
        EXPECT_TRUE(walker.says(one.named)) << walker.text();
        EXPECT_FALSE(walker.assistant.can_go_on(walker.session));
        walker.assistant.again(walker.session);
        EXPECT_EQ(walker.verdict(), Verdict::open);
        walker.assistant.leave(walker.session);
        EXPECT_NE(walker.assistant.holds_back(), "");
        EXPECT_TRUE(walker.session.is_kept_released());
    }
}

/// The emulator breaks it, and a person confirms every motion. self_test_test.cpp has all faults.
TEST(AssistantWalk, ASelfTestIsPassedIfTheForceKeepsItsDirection) {
    for (const auto &[fault, verdict, says] :
         {std::tuple("lost-counts:2:0.1", Verdict::bad, "counts are lost"),
          {"sensor-gain:1:1.1", Verdict::doubtful, "the current sensor of motor 1 has a gain"}}) {
        SCOPED_TRACE(fault);
        Walker walker({fault});
        walker.walk_to(StepName::self_test);
        walker.test();
        EXPECT_EQ(walker.verdict(), verdict) << walker.text();
        EXPECT_TRUE(walker.says(says)) << walker.text();
        EXPECT_FALSE(walker.assistant.can_go_on(walker.session));
        walker.assistant.continue_all_the_same(walker.session);
        const bool is_passed = walker.assistant.present() == StepName::calibration;
        EXPECT_EQ(is_passed, verdict == Verdict::doubtful);
        walker.assistant.leave(walker.session);
        EXPECT_EQ(walker.session.is_kept_released(), verdict == Verdict::bad);
    }
}

TEST(AssistantWalk, AZeroThatWasSetElsewhereIsFoundAndAnotherZeroVoidsTheSelfTest) {
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
    walker.next();
    walker.assistant.go_to(walker.session, StepName::zeroing);
    EXPECT_EQ(walker.assistant.state(StepName::self_test), StepState::done);
    walker.zero();
    walker.run(0.1);
    EXPECT_EQ(walker.assistant.state(StepName::self_test), StepState::open);
}

TEST(AssistantWalk, AStopAndAPulledCableEndTheSelfTestWhichIsDoneAgain) {
    Walker walker;
    walker.walk_to(StepName::self_test);
    walker.choose("start");
    walker.run(1.5);
    walker.session.servo().emergency_stop();
    walker.run(0.2);
    EXPECT_FALSE(walker.session.is_in_exclusive_use());
    EXPECT_TRUE(walker.says("emergency stop")) << walker.text();
    EXPECT_FALSE(walker.offers("start"));
    walker.assistant.again(walker.session);
    walker.run(0.2);
    EXPECT_EQ(walker.session.latest().safety.state, servo::SafetyState::waiting);

    walker.choose("start");
    walker.run(1.5);
    ASSERT_TRUE(walker.session.is_in_exclusive_use());
    walker.session.device().emulated()->set_plugged(false); // in lockstep nobody else uses it
    ASSERT_TRUE(walker.run_until([&] { return !walker.session.is_in_exclusive_use(); }, 5.0));
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

TEST(AssistantWalk, ALossyConnectionIsDoubtful) {
    Walker walker({"drop:in:0.02"});
    EXPECT_TRUE(walker.run_until([&] { return walker.verdict() == Verdict::doubtful; }, 5.0));
    EXPECT_TRUE(walker.says("did not arrive whole")) << walker.text();
    walker.assistant.continue_all_the_same(walker.session);
    EXPECT_EQ(walker.assistant.present(), StepName::identity);
}

TEST(AssistantWalk, AFaultOfTheBoardSaysWhatToDoAndNotToGoOn) {
    Walker failed({"failed-sensor:2"});
    failed.run(3.0);
    EXPECT_FALSE(failed.assistant.can_go_on(failed.session));
    EXPECT_TRUE(failed.says("look at the plugs and the supply of the current sensors"))
        << failed.text();
    EXPECT_FALSE(failed.says("Press Next")) << failed.text();

    Walker pressed({"stop@1-4"});
    pressed.run(2.0);
    EXPECT_TRUE(pressed.says("stop switch")) << pressed.text();
    EXPECT_FALSE(pressed.assistant.can_go_on(pressed.session));
    pressed.run(2.5);
    pressed.assistant.again(pressed.session);
    pressed.next();
    EXPECT_EQ(pressed.assistant.present(), StepName::identity);
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

TEST(CalibrationVerdict, OnlyWhatContradictsTheDeviceFileMustNotBePassed) {
    const auto judged = [](CalibrationProblem problem, servo::TripCause trip = {}) {
        commissioning::CalibrationReport found;
        found.kind = problem;
        found.trip = trip;
        StepReport report;
        judge(found, report);
        return report;
    };
    for (const CalibrationProblem problem :
         {CalibrationProblem::contradiction, CalibrationProblem::of_another_kind}) {
        EXPECT_EQ(judged(problem).verdict, Verdict::bad);
    }
    for (const CalibrationProblem problem :
         {CalibrationProblem::ended, CalibrationProblem::stopped, CalibrationProblem::never_at_rest,
          CalibrationProblem::little_motion}) {
        EXPECT_EQ(judged(problem).verdict, Verdict::doubtful);
        EXPECT_NE(judged(problem).troubles.at(0).remedy, "");
    }
    const StepReport too_fast = judged(CalibrationProblem::stopped, servo::TripCause::tip_speed);
    EXPECT_NE(too_fast.troubles.at(0).remedy.find("more slowly"), std::string::npos);
}

} // namespace
} // namespace springdrive::app::assistant

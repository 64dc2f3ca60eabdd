// Covers app/assistant/assistant.cpp: the sequence of steps, whatever they are, and
// the file by which it is resumed.
#include "app/assistant/assistant.h"

#include "base/input_error.h"
#include "tests/app/assistant/walker.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

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

} // namespace
} // namespace springdrive::app::assistant

// Covers app/study/{sitting/sitting,participant/answers}.cpp: the questionnaire.
#include "app/study/participant/answers.h"
#include "tests/app/study/sitting_rig.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

using study::SessionEnding;

ParticipantInput letter(const std::string &text) {
    ParticipantInput input;
    input.source = InputSource::letter;
    input.name = text;
    return input;
}

ParticipantInput click(std::size_t choice) {
    ParticipantInput input;
    input.source = InputSource::choice;
    input.choice = choice;
    return input;
}

TEST_F(StudySitting, AsksItsQuestionsAndOnceIfTheyWereAnswered) {
    using study::QuestionnaireKind;
    using study::QuestionnaireTime;
    study::QuestionnaireItem hand{"hand", QuestionnaireTime::before, "Which hand?",
                                  QuestionnaireKind::choice};
    hand.choices = {"left", "right"};
    study::QuestionnaireItem sure{"sure", QuestionnaireTime::before, "How sure?",
                                  QuestionnaireKind::scale};
    sure.lowest = 0;
    sure.highest = 5;
    const study::QuestionnaireItem age{"age", QuestionnaireTime::before, "How old?"};
    const study::QuestionnaireItem more{"more", QuestionnaireTime::after, "Anything else?"};
    protocol_.questionnaire = {hand, sure, age, more};

    std::vector<std::string> asked;
    const auto answers = [&asked](MadeUpPort &port, bool stops) {
        port.on_frame = [&asked, &port, stops](const ParticipantPicture &picture,
                                               const SittingState &state) {
            port.orders.stops = stops && state.step == SittingStep::interval;
            if (state.step != SittingStep::questionnaire) {
                return;
            }
            if (asked.empty() || asked.back() != picture.text) {
                asked.push_back(picture.text);
            }
            if (picture.text == "Which hand?") {
                port.inputs = {MadeUpPort::key("2", 0.0)};
            } else if (picture.text == "How sure?") {
                port.inputs = {MadeUpPort::key("0", 0.0)};
            } else if (picture.text == "How old?") {
                port.inputs = {click(picture.choices.size() - 1)}; // would rather not say
            } else {
                port.inputs = {letter("n"), letter("ö"), MadeUpPort::key("enter", 0.0)};
            }
        };
    };
    EXPECT_EQ(run([&](MadeUpPort &port, session::Session &) { answers(port, true); }),
              SessionEnding::stopped);
    EXPECT_EQ(asked, (std::vector<std::string>{"Which hand?", "How sure?", "How old?"}));
    asked.clear();
    EXPECT_EQ(run([&](MadeUpPort &port, session::Session &) { answers(port, false); }),
              SessionEnding::completed);
    EXPECT_EQ(asked, (std::vector<std::string>{"How old?", "Anything else?"}));

    const std::vector<study::QuestionnaireAnswer> stored = study::read_study(file()).answers;
    ASSERT_EQ(stored.size(), 3U);
    EXPECT_EQ(stored[0].answer, "right");
    EXPECT_EQ(stored[1].answer, "0");
    EXPECT_EQ(stored[2].answer, "nö");
    EXPECT_EQ(stored[2].session, 2);
}

/// Each is on the disk when the next one is asked; what is missing makes a session of its own.
TEST_F(StudySitting, GoesOnWithQuestionsAfterTheLastTrialThatWereBrokenOff) {
    using study::QuestionnaireTime;
    protocol_.questionnaire = {{"more", QuestionnaireTime::after, "Anything else?"},
                               {"again", QuestionnaireTime::after, "Once more?"}};
    std::vector<std::string> asked;
    const auto session = [&](bool stops) {
        asked.clear();
        return run([&asked, stops](MadeUpPort &port, session::Session &) {
            port.on_frame = [&asked, &port, stops](const ParticipantPicture &picture,
                                                   const SittingState &state) {
                if (state.step == SittingStep::questionnaire) {
                    asked.push_back(picture.text);
                    port.orders.stops = stops && picture.text == "Once more?";
                    port.inputs = {letter("n"), MadeUpPort::key("enter", 0.0)};
                }
            };
        });
    };
    EXPECT_EQ(session(true), SessionEnding::stopped);
    EXPECT_EQ(asked, (std::vector<std::string>{"Anything else?", "Once more?"}));
    const study::StudyContents before = study::read_study(file());
    EXPECT_EQ(before.trials.size(), headless().size());
    EXPECT_EQ(before.answers.size(), 1U);

    EXPECT_EQ(session(false), SessionEnding::completed);
    EXPECT_EQ(asked, (std::vector<std::string>{"Once more?"}));
    EXPECT_FALSE(steps_.contains(SittingStep::instructions));
    EXPECT_FALSE(steps_.contains(SittingStep::interval));
    EXPECT_TRUE(steps_.contains(SittingStep::over));
    const study::StudyContents after = study::read_study(file());
    EXPECT_EQ(after.trials.size(), before.trials.size());
    ASSERT_EQ(after.answers.size(), 2U);
    EXPECT_EQ(after.answers[1].item, "again");
    EXPECT_EQ(after.answers[1].session, 2);
}

} // namespace
} // namespace springdrive::app::study_screen

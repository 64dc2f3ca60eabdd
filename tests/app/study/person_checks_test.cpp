// Covers app/study/sitting/person_checks.cpp and questions.cpp.
#include "app/study/sitting/person_checks.h"

#include "app/study/sitting/questions.h"
#include "tests/engine/study/protocol/plain_protocol.h"

#include <gtest/gtest.h>

#include <string>

namespace springdrive::app::study_screen {
namespace {

using testing::kPlainProtocol;
using testing::protocol_of;

std::string said_of(const study::Protocol &protocol) {
    std::string said;
    for (const study::ProtocolFinding &finding : check_for_persons(protocol)) {
        said += text_of(finding) + '\n';
    }
    return said;
}

TEST(PersonChecks, FindNothingInASoundProtocol) {
    const study::Protocol protocol = protocol_of(kPlainProtocol);
    EXPECT_EQ(said_of(protocol), "");
    EXPECT_EQ(what_keeps_persons_out(protocol), "");
}

TEST(PersonChecks, FindKeysThatNobodyCanPress) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    protocol.responses.keys[1] = "f13";
    const std::string wrong = "with a person: responses.keys has \"f13\"; a key is a letter, a "
                              "digit or one of left, right, up, down, enter, f1 and so on";
    EXPECT_EQ(said_of(protocol), "error: " + wrong + '\n');
    EXPECT_EQ(what_keeps_persons_out(protocol), wrong);
    protocol.responses.keys[1] = "F11";
    EXPECT_EQ(said_of(protocol), "");
}

TEST(PersonChecks, FindWhatCannotBeAdjustedWhileItIsFelt) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    protocol.variable.parameter = "press_N";
    EXPECT_EQ(said_of(protocol), "") << "it is no adjustment";
    protocol.task.kind = study::TaskKind::adjustment;
    EXPECT_EQ(what_keeps_persons_out(protocol),
              "with a person: variable.parameter is press_N, which cannot be adjusted while it is "
              "felt; adjust a gain, such as eta, or choose another task");
    protocol.variable.parameter = "eta";
    EXPECT_EQ(what_keeps_persons_out(protocol), "");
}

/// A line of instructions takes at least 1/36 of the height, so that no more than 36 fit.
TEST(PersonChecks, FindTextsThatAreTooLongToRead) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    const auto lines = [](int count) {
        std::string text = "a";
        for (int i = 1; i < count; ++i) {
            text += "\na";
        }
        return text;
    };
    protocol.texts.instructions = lines(15); // less than half
    EXPECT_EQ(said_of(protocol), "");
    protocol.texts.instructions = lines(37);
    EXPECT_EQ(said_of(protocol).find("warning: texts.instructions: does not fit"), 0U)
        << said_of(protocol);
    EXPECT_EQ(what_keeps_persons_out(protocol), "");
    protocol.texts.instructions = "a";
    protocol.questionnaire[0].text = lines(37);
    EXPECT_EQ(said_of(protocol).find("warning: questions.hand: does not fit"), 0U)
        << said_of(protocol);
}

TEST(Questions, AreAnsweredByTheKeysOnTheirPlates) {
    const study::QuestionnaireItem item{.name = "hand",
                                        .when = study::QuestionnaireTime::after,
                                        .text = "Which hand?",
                                        .kind = study::QuestionnaireKind::choice,
                                        .choices = {"right", "left"}};
    const std::vector<QuestionChoice> choices = choices_of(item, study::Texts{});
    const ParticipantPicture picture = picture_of(item, study::Texts{});
    ASSERT_EQ(choices.size(), 3U);
    ASSERT_EQ(picture.choices.size(), 3U);
    EXPECT_EQ(picture.heading, study::Texts{}.questionnaire_after);
    EXPECT_EQ(picture.text, "Which hand?");
    EXPECT_EQ(picture.choices[1].text, "left");
    EXPECT_EQ(picture.choices[1].key, "2");
    EXPECT_FALSE(picture.has_text_field);
    const auto answer_by = [&](const ParticipantInput &input) {
        const QuestionChoice *const chosen = chosen_by(choices, input);
        return chosen == nullptr ? "-" : chosen->answer.value_or("none");
    };
    EXPECT_EQ(answer_by({.source = InputSource::key, .name = "2"}), "left");
    EXPECT_EQ(answer_by({.source = InputSource::key, .name = "2", .is_press = false}), "-");
    EXPECT_EQ(answer_by({.source = InputSource::key, .name = "3"}), "-");
    EXPECT_EQ(answer_by({.source = InputSource::choice, .name = "", .choice = 2}), "none");
    EXPECT_EQ(answer_by({.source = InputSource::choice, .name = "", .choice = 3}), "-");
}

} // namespace
} // namespace springdrive::app::study_screen

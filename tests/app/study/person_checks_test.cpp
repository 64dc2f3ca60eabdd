// Covers app/study/sitting/person_checks.cpp and questions.cpp.
#include "app/study/sitting/person_checks.h"

#include "app/study/sitting/questions.h"
#include "tests/engine/study/protocol/plain_protocol.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

namespace springdrive::app::study_screen {
namespace {

using testing::kPlainProtocol;
using testing::protocol_of;

/// All of its spots are on a floor.
study::StudySetting on_floor(const study::Protocol &protocol) {
    study::StudySetting setting;
    setting.conditions.resize(protocol.conditions.size());
    for (study::PlacedCondition &condition : setting.conditions) {
        condition.spot.normal = Vector3::UnitY();
    }
    return setting;
}

std::string kept_out(const study::Protocol &protocol) {
    return validate_for_participants(protocol, on_floor(protocol));
}

std::string said_of(const study::Protocol &protocol) {
    std::string said;
    for (const study::ProtocolFinding &finding : check_for_persons(protocol, on_floor(protocol))) {
        said += text_of(finding) + '\n';
    }
    return said;
}

TEST(PersonChecks, FindNothingInASoundProtocol) {
    const study::Protocol protocol = protocol_of(kPlainProtocol);
    EXPECT_EQ(said_of(protocol), "");
    EXPECT_EQ(kept_out(protocol), "");
}

TEST(PersonChecks, FindKeysThatNobodyCanPress) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    protocol.responses.keys[1] = "f13";
    const std::string wrong = "with a person: responses.keys has \"f13\"; a key is a letter, a "
                              "digit or one of left, right, up, down, enter, f1 and so on";
    EXPECT_EQ(said_of(protocol), "error: " + wrong + '\n');
    EXPECT_EQ(kept_out(protocol), wrong);
    protocol.responses.keys[1] = "F11";
    EXPECT_EQ(said_of(protocol), "");
}

/// A hand that leaves the surface would answer by that.
TEST(PersonChecks, FindGesturesThatLeaveTheSurface) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    ASSERT_NE(protocol.stimulus, study::StimulusForm::stroke);
    study::StudySetting setting = on_floor(protocol);
    const auto tilt = [&setting](double degrees) { // towards the user
        const double angle = degrees * std::numbers::pi / 180.0;
        setting.conditions.front().spot.normal = {0.0, std::cos(angle), std::sin(angle)};
    };
    const auto wrong = [&] { return validate_for_participants(protocol, setting); };
    protocol.responses = {study::ResponseDevice::gesture, {"left", "right"}};
    EXPECT_EQ(wrong(), "");
    protocol.responses.keys = {"left", "Down"};
    EXPECT_EQ(wrong(),
              "with a person: responses.keys has \"Down\", which is the way off the surface "
              "in condition \"" +
                  protocol.conditions.front().name + "\"; take gestures to its sides");
    protocol.responses.keys = {"towards", "away"};
    tilt(44.0);
    EXPECT_EQ(wrong(), "");
    tilt(46.0);
    EXPECT_NE(wrong(), "");
    protocol.stimulus = study::StimulusForm::stroke; // in free space
    EXPECT_EQ(wrong(), "");
    protocol.stimulus = study::StimulusForm::press;
    protocol.responses = {study::ResponseDevice::keyboard, {"up", "down"}};
    EXPECT_EQ(wrong(), "");
}

TEST(PersonChecks, FindWhatCannotBeAdjustedWhileItIsFelt) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    protocol.variable.parameter = "press_N";
    EXPECT_EQ(said_of(protocol), "") << "it is no adjustment";
    protocol.task.kind = study::TaskKind::adjustment;
    EXPECT_EQ(kept_out(protocol),
              "with a person: variable.parameter is press_N, which cannot be adjusted while it is "
              "felt; adjust a gain, such as eta, or choose another task");
    protocol.variable.parameter = "eta";
    EXPECT_EQ(kept_out(protocol), "");
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
    EXPECT_EQ(kept_out(protocol), "");
    protocol.texts.instructions = "a";
    protocol.questionnaire[0].text = lines(37);
    EXPECT_EQ(said_of(protocol).find("warning: questions.hand: does not fit"), 0U)
        << said_of(protocol);
}

TEST(Questions, AreAnsweredByTheKeysOnTheirCards) {
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

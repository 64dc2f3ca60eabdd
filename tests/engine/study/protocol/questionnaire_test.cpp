// Covers engine/study/protocol/questionnaire.cpp: which answers are possible. What items are
// refused in files is in protocol_file_test.cpp.
#include "engine/study/protocol/questionnaire.h"

#include "tests/engine/study/protocol/plain_protocol.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace springdrive::study {
namespace {

QuestionnaireItem scale(int lowest, int highest) {
    return {.name = "tiring",
            .when = QuestionnaireTime::after,
            .text = "How tiring?",
            .kind = QuestionnaireKind::scale,
            .lowest = lowest,
            .highest = highest,
            .lowest_label = "not",
            .highest_label = "very"};
}

QuestionnaireItem choice() {
    return {.name = "hand",
            .text = "Which hand?",
            .kind = QuestionnaireKind::choice,
            .choices = {"right", "left", "beide, nämlich"}};
}

TEST(Questionnaire, AScaleTakesItsWholeNumbersAlone) {
    for (const char *const answer : {"-2", "-1", "0", "1", "2", "3"}) {
        EXPECT_EQ(validate_answer(scale(-2, 3), answer), "") << answer;
    }
    for (const char *const answer :
         {"-3", "4", "", " 1", "1 ", "+1", "01", "1.0", "1e0", "-0", "one", "٣", "1\n"}) {
        const std::string said = validate_answer(scale(-2, 3), answer);
        EXPECT_EQ(said.rfind("answer is '", 0), 0U) << answer << ": " << said;
        EXPECT_NE(said.find("; it must be a whole number from -2 to 3"), std::string::npos) << said;
    }
}

TEST(Questionnaire, AChoiceTakesItsTextsToTheLetter) {
    for (const std::string &answer : choice().choices) {
        EXPECT_EQ(validate_answer(choice(), answer), "") << answer;
    }
    for (const char *const answer : {"", "Right", "right ", "righ", "1", "beide"}) {
        EXPECT_NE(validate_answer(choice(), answer)
                      .find("'; it must be one of 'right', 'left', 'beide, nämlich'"),
                  std::string::npos)
            << answer;
    }
}

TEST(Questionnaire, AFreeTextTakesWhatCanBeRead) {
    const QuestionnaireItem item{.name = "remarks", .text = "Anything else?"};
    ASSERT_EQ(validate(item), "");
    for (const std::string &answer : {std::string(), std::string("two\nlines, \"quoted\"\t;"),
                                      std::string("schön – 硬い"), std::string(kMaxAnswer, 'a')}) {
        EXPECT_EQ(validate_answer(item, answer), "");
    }
    EXPECT_EQ(validate_answer(item, std::string(kMaxAnswer + 1, 'a')),
              "answer has 10001 bytes; it must have 0 to 10000");
    for (const char control : {'\0', '\r', '\x1b', '\x7f'}) {
        EXPECT_NE(
            validate_answer(item, std::string("a") + control + "b").find("no control characters"),
            std::string::npos);
    }
}

TEST(Questionnaire, EveryPossibleAnswerOfAnItemIsOne) {
    for (const QuestionnaireItem &item :
         testing::protocol_of(testing::kPlainProtocol).questionnaire) {
        EXPECT_EQ(validate(item), "");
        for (const std::string &answer : possible_answers(item)) {
            EXPECT_EQ(validate_answer(item, answer), "");
        }
    }
    EXPECT_EQ(possible_answers(scale(-1, 1)), (std::vector<std::string>{"-1", "0", "1"}));
    EXPECT_EQ(possible_answers(scale(0, kMaxScaleSteps)).size(), 101U);
    EXPECT_EQ(possible_answers(choice()), choice().choices);
}

} // namespace
} // namespace springdrive::study

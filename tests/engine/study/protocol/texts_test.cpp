// Covers engine/study/protocol/texts.cpp and the German texts of docs/study_protocol.md. What
// questions are refused in files is in protocol_file_test.cpp.
#include "engine/study/protocol/texts.h"
#include "tests/engine/study/protocol/plain_protocol.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <vector>

namespace springdrive::study {
namespace {

std::string Texts::*member_of(const Field<Texts> &field) {
    return std::get<std::string Texts::*>(field.member);
}

TEST(Texts, AllAreInTheList) {
    std::set<std::string_view> keys;
    std::set<const std::string *> texts;
    const Texts by_default;
    for (const Field<Texts> &one : kTextFields) {
        keys.insert(one.name);
        texts.insert(&(by_default.*member_of(one)));
        EXPECT_FALSE((by_default.*member_of(one)).empty()) << one.name;
        EXPECT_FALSE(one.help.empty()) << one.name;
    }
    EXPECT_EQ(keys.size(), kTextFields.size());
    EXPECT_EQ(texts.size(), kTextFields.size());
    EXPECT_EQ(sizeof(Texts), kTextFields.size() * sizeof(std::string)) << "and no other";
    EXPECT_EQ(validate(by_default), "");
}

TEST(Texts, PlaceholdersAreFilledIn) {
    EXPECT_EQ(filled("noch {} s", "{}", "12"), "noch 12 s");
    EXPECT_EQ(filled("{}", "{}", "{}"), "{}") << "once only";
    EXPECT_EQ(filled(filled("{begin}, {again}", "{again}", "n"), "{begin}", "y"), "y, n");
    EXPECT_EQ(filled("none", "{}", "12"), "none");
}

TEST(Texts, EachPlaceholderIsThereOnce) {
    const std::map<std::string_view, std::string> placeholders{
        {"understood", "{again}{begin}"}, {"progress", "{}"}, {"break_left", "{}"}};
    for (const Field<Texts> &one : kTextFields) {
        Texts texts;
        std::string &text = texts.*member_of(one);
        const auto has = placeholders.find(one.name);
        const std::string all = has == placeholders.end() ? "" : has->second;
        text = "a " + all;
        EXPECT_EQ(validate(texts), "") << one.name;
        text = "a " + all + all;
        EXPECT_EQ(validate(texts).empty(), all.empty()) << one.name;
        text = "a";
        EXPECT_EQ(validate(texts).empty(), all.empty()) << one.name;
        text = "a {other} " + all;
        EXPECT_EQ(validate(texts).rfind(std::string(one.name) + " has '{other}'", 0), 0U)
            << one.name;
    }
    Texts smiling;
    smiling.end = "Thank you :-}";
    EXPECT_EQ(validate(smiling), "");
}

/// The first block of TOML after a heading of a page.
std::string toml_after(const std::string &page, const std::string &heading) {
    const std::size_t at = page.find(heading);
    EXPECT_NE(at, std::string::npos) << heading;
    const std::string opening = "```toml\n";
    const std::size_t from = page.find(opening, at) + opening.size();
    return page.substr(from, page.find("```", from) - from);
}

/// The page's German texts are complete, and a shipped protocol may have them.
TEST(Texts, TheManualHasThemInGerman) {
    const std::string german =
        toml_after(testing::contents_of(testing::assets().parent_path() / "docs/study_protocol.md"),
                   "## In another language");
    std::string direction =
        testing::contents_of(testing::assets() / "protocols" / "direction.toml");
    const std::size_t from = direction.find("[texts]");
    direction.replace(from, direction.find("# What all conditions", from) - from, german);
    const Protocol protocol = testing::protocol_of(direction);
    EXPECT_EQ(protocol.language, "de");
    for (const Field<Texts> &one : kTextFields) {
        EXPECT_NE(german.find("\n" + std::string(one.name) + " = "), std::string::npos) << one.name;
    }
    EXPECT_NE(protocol.texts, Texts{});
}

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
        EXPECT_NE(said.find("from -2 to 3"), std::string::npos) << answer << ": " << said;
    }
}

TEST(Questionnaire, AChoiceTakesItsTextsToTheLetter) {
    for (const std::string &answer : choice().choices) {
        EXPECT_EQ(validate_answer(choice(), answer), "") << answer;
    }
    for (const char *const answer : {"", "Right", "right ", "righ", "1", "beide"}) {
        EXPECT_NE(validate_answer(choice(), answer).find("'beide, nämlich'"), std::string::npos);
    }
}

TEST(Questionnaire, AFreeTextTakesWhatCanBeRead) {
    const QuestionnaireItem item{.name = "remarks", .text = "Anything else?"};
    ASSERT_EQ(validate(item), "");
    for (const std::string &answer : {std::string(), std::string("two\nlines, \"quoted\"\t;"),
                                      std::string("schön – 硬い"), std::string(kMaxAnswer, 'a')}) {
        EXPECT_EQ(validate_answer(item, answer), "");
    }
    EXPECT_NE(validate_answer(item, std::string(kMaxAnswer + 1, 'a')), "");
    for (const char control : {'\0', '\r', '\x1b', '\x7f'}) {
        EXPECT_NE(validate_answer(item, std::string("a") + control + "b"), "");
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

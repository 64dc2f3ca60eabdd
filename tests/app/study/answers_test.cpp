// Covers app/study/participant/answers.cpp: what is drawn of the ways to answer is what they do.
#include "app/study/participant/answers.h"

#include "tests/engine/study/protocol/plain_protocol.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

using Keys = std::vector<std::string>;

std::vector<std::string> drawn(study::Protocol protocol, study::ResponseDevice device, Keys keys) {
    protocol.responses = {device, std::move(keys)};
    std::vector<std::string> labels;
    for (const AnswerChoice &choice : choices_of(protocol)) {
        labels.push_back(choice.key);
    }
    return labels;
}

TEST(Answers, LeftIsDrawnOnTheLeftOfRight) {
    const study::Protocol protocol = testing::protocol_of(testing::kPlainProtocol);
    for (const study::ResponseDevice device :
         {study::ResponseDevice::keyboard, study::ResponseDevice::mouse,
          study::ResponseDevice::gesture}) {
        EXPECT_EQ(drawn(protocol, device, {"right", "left"}),
                  drawn(protocol, device, {"left", "right"}));
        EXPECT_EQ(drawn(protocol, device, {"Right", "LEFT"}),
                  drawn(protocol, device, {"left", "right"}));
    }
    const study::ResponseDevice keyboard = study::ResponseDevice::keyboard;
    EXPECT_EQ(drawn(protocol, keyboard, {"y", "n"}), (Keys{"Y", "N"}));
    EXPECT_NE(drawn(protocol, keyboard, {"down", "up"}), drawn(protocol, keyboard, {"up", "down"}));
}

TEST(Answers, ACardSaysWhatTheAnswerMeansUnlessTheKeyDoes) {
    study::Protocol protocol = testing::protocol_of(testing::kPlainProtocol);
    const auto meanings = [&protocol] {
        std::vector<std::string> texts;
        for (const AnswerChoice &choice : choices_of(protocol)) {
            texts.push_back(choice.text);
        }
        return texts;
    };
    ASSERT_EQ(protocol.task.kind, study::TaskKind::forced_choice_by_interval);
    protocol.responses.keys = {"1", "2"};
    protocol.texts.first_interval = "First";
    protocol.texts.second_interval = "2";
    EXPECT_EQ(meanings(), (Keys{"First", ""}));
    protocol.task.kind = study::TaskKind::yes_no;
    EXPECT_EQ(meanings(), (Keys{"no", "yes"}));
}

TEST(Answers, AGestureIsTheKeyAlongWhichTheTipWentFurthest) {
    const study::ResponseWays ways{study::ResponseDevice::gesture, {"right", "left"}};
    constexpr double kBeyond_m = 1.01 * kGesture_m;
    constexpr double kWithin_m = 0.99 * kGesture_m;
    EXPECT_EQ(alternative_of(ways, Vector3(kBeyond_m, 0.0, 0.0)), 0U);
    EXPECT_EQ(alternative_of(ways, Vector3(-kBeyond_m, 0.0, 0.0)), 1U);
    EXPECT_EQ(alternative_of(ways, Vector3(kWithin_m, 0.0, 0.0)), std::nullopt);
    EXPECT_EQ(alternative_of(ways, Vector3(kWithin_m, 0.1, 0.1)), std::nullopt) << "up is no key";
    EXPECT_EQ(alternative_of(ways, Vector3(kBeyond_m, 0.1, 0.0)), 0U);
    const study::ResponseWays four{study::ResponseDevice::gesture,
                                   {"left", "right", "towards", "away"}};
    EXPECT_EQ(alternative_of(four, Vector3(0.03, 0.0, 0.04)), 2U);
    EXPECT_EQ(alternative_of(four, Vector3(0.03, 0.0, -0.025)), 1U);
    const study::ResponseWays keys{study::ResponseDevice::keyboard, {"right", "left"}};
    EXPECT_EQ(alternative_of(keys, Vector3(0.1, 0.0, 0.0)), std::nullopt);
}

TEST(Answers, AClickOnACardGivesWhatItsKeyDoes) {
    study::Protocol protocol = testing::protocol_of(testing::kPlainProtocol);
    for (const Keys &keys : {Keys{"right", "left"}, Keys{"left", "right"}, Keys{"y", "n"},
                             Keys{"right", "left", "up"}}) {
        protocol.responses = {study::ResponseDevice::keyboard, keys};
        const std::vector<AnswerChoice> cards = choices_of(protocol);
        ASSERT_EQ(cards.size(), keys.size());
        std::vector<bool> is_reached(keys.size());
        for (std::size_t card = 0; card < cards.size(); ++card) {
            ParticipantInput click;
            click.source = InputSource::choice;
            click.choice = card;
            const std::size_t clicked = alternative_of(protocol.responses, click).value();
            EXPECT_EQ(shown_key(keys.at(clicked), false), cards[card].key);
            is_reached[clicked] = true;
            ParticipantInput press;
            press.name = keys.at(clicked);
            EXPECT_EQ(alternative_of(protocol.responses, press), clicked);
        }
        EXPECT_EQ(is_reached, std::vector<bool>(keys.size(), true));
        ParticipantInput beside;
        beside.source = InputSource::choice;
        beside.choice = keys.size();
        EXPECT_EQ(alternative_of(protocol.responses, beside), std::nullopt);
    }
}

} // namespace
} // namespace springdrive::app::study_screen

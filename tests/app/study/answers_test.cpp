// Covers app/study/participant/answers.cpp, and app/study/sitting/person_checks.cpp: what is drawn
// of the ways to answer is what they do, and what keeps persons out of a protocol. And
// app/study/experimenter/live_charts.cpp: what the experimenter sees of the answers so far.
#include "app/study/experimenter/live_charts.h"
#include "app/study/participant/answers.h"
#include "app/study/sitting/person_checks.h"
#include "app/widgets/widgets.h"
#include "tests/app/study/headless_study.h"
#include "tests/app/study/made_up_people.h"
#include "tests/engine/study/protocol/plain_protocol.h"
#include "tests/support/files.h"
#include "tests/support/imgui_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <string>
#include <thread>
#include <variant>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

using study::ResponseDevice;
using testing::kPlainProtocol;
using testing::protocol_of;
using Keys = std::vector<std::string>;

Keys drawn(ResponseDevice device, Keys keys) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    protocol.responses = {device, std::move(keys)};
    Keys labels;
    for (const AnswerChoice &choice : choices_of(protocol)) {
        labels.push_back(choice.key);
    }
    return labels;
}

TEST(Answers, LeftIsDrawnOnTheLeftOfRight) {
    for (const ResponseDevice device :
         {ResponseDevice::keyboard, ResponseDevice::mouse, ResponseDevice::gesture}) {
        EXPECT_EQ(drawn(device, {"Right", "LEFT"}), drawn(device, {"left", "right"}));
    }
    EXPECT_EQ(drawn(ResponseDevice::keyboard, {"y", "n"}), (Keys{"Y", "N"}));
    EXPECT_EQ(drawn(ResponseDevice::keyboard, {"down", "up"}), (Keys{"↓", "↑"}));
}

TEST(Answers, ACardSaysWhatTheAnswerMeansUnlessTheKeyDoes) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    const auto meanings = [&protocol] {
        Keys texts;
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
    constexpr double kBeyond_m = 1.01 * kGesture_m;
    constexpr double kWithin_m = 0.99 * kGesture_m;
    const Keys sides{"right", "left"};
    const Keys four{"left", "right", "towards", "away"};
    struct Case {
        ResponseDevice device;
        Keys keys;
        Vector3 moved_m;
        std::optional<std::size_t> given;
    };
    for (const Case &one : std::vector<Case>{
             {ResponseDevice::gesture, sides, {kBeyond_m, 0.0, 0.0}, 0U},
             {ResponseDevice::gesture, sides, {-kBeyond_m, 0.0, 0.0}, 1U},
             {ResponseDevice::gesture, sides, {kWithin_m, 0.0, 0.0}, std::nullopt},
             {ResponseDevice::gesture, sides, {kWithin_m, 0.1, 0.1}, std::nullopt}, // no key
             {ResponseDevice::gesture, sides, {kBeyond_m, 0.1, 0.0}, 0U},
             {ResponseDevice::gesture, four, {0.03, 0.0, 0.04}, 2U},
             {ResponseDevice::gesture, four, {0.03, 0.0, -0.025}, 1U},
             {ResponseDevice::keyboard, sides, {0.1, 0.0, 0.0}, std::nullopt}}) {
        EXPECT_EQ(alternative_of({one.device, one.keys}, one.moved_m), one.given)
            << one.moved_m.transpose();
    }
}

TEST(Answers, AClickOnACardGivesWhatItsKeyDoes) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    for (const Keys &keys : {Keys{"right", "left"}, Keys{"left", "right"}, Keys{"y", "n"},
                             Keys{"right", "left", "up"}}) {
        protocol.responses = {ResponseDevice::keyboard, keys};
        const std::vector<AnswerChoice> cards = choices_of(protocol);
        ASSERT_EQ(cards.size(), keys.size());
        const auto clicked = [&](std::size_t card) {
            return alternative_of(protocol.responses,
                                  {.source = InputSource::choice, .name = "", .choice = card});
        };
        std::vector<bool> is_reached(keys.size());
        for (std::size_t card = 0; card < cards.size(); ++card) {
            const std::size_t given = clicked(card).value();
            EXPECT_EQ(shown_key(keys.at(given), false), cards[card].key);
            is_reached[given] = true;
            EXPECT_EQ(alternative_of(protocol.responses, {.name = keys.at(given)}), given);
        }
        EXPECT_EQ(is_reached, std::vector<bool>(keys.size(), true));
        EXPECT_EQ(clicked(keys.size()), std::nullopt);
    }
}

TEST(Answers, ToQuestionsAreGivenByTheKeysOnTheirCards) {
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
    EXPECT_EQ(picture.choices[1], (AnswerChoice{"left", "2"}));
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

/// All of its spots are tilted so far towards the user.
study::StudySetting on_slope(const study::Protocol &protocol, double degrees) {
    const double angle = degrees * std::numbers::pi / 180.0;
    study::StudySetting setting;
    setting.conditions.resize(protocol.conditions.size());
    for (study::PlacedCondition &condition : setting.conditions) {
        condition.spot.normal = {0.0, std::cos(angle), std::sin(angle)};
    }
    return setting;
}

std::string kept_out(const study::Protocol &protocol, double degrees = 0.0) {
    return validate_for_participants(protocol, on_slope(protocol, degrees));
}

std::string said_of(const study::Protocol &protocol) {
    std::string said;
    for (const study::ProtocolFinding &finding :
         check_for_persons(protocol, on_slope(protocol, 0.0))) {
        said += text_of(finding) + '\n';
    }
    return said;
}

TEST(PersonChecks, FindKeysThatNobodyCanPress) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    EXPECT_EQ(said_of(protocol), "");
    EXPECT_EQ(kept_out(protocol), "");
    protocol.responses.keys[1] = "f13";
    const std::string wrong = kept_out(protocol);
    EXPECT_TRUE(wrong.starts_with("with a person: responses.keys has \"f13\"")) << wrong;
    EXPECT_EQ(said_of(protocol), "error: " + wrong + '\n');
    protocol.responses.keys[1] = "F11";
    EXPECT_EQ(said_of(protocol), "");
}

/// A hand that leaves the surface would answer by that.
TEST(PersonChecks, FindGesturesThatLeaveTheSurface) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    protocol.responses = {ResponseDevice::gesture, {"left", "right"}};
    EXPECT_EQ(kept_out(protocol), "");
    protocol.responses.keys = {"left", "Down"};
    EXPECT_NE(kept_out(protocol).find("\"Down\", which is the way off the surface in condition \"" +
                                      protocol.conditions.front().name + "\"; take gestures"),
              std::string::npos)
        << kept_out(protocol);
    protocol.responses.keys = {"towards", "away"};
    EXPECT_EQ(kept_out(protocol, 44.0), "");
    EXPECT_NE(kept_out(protocol, 46.0), "");
    protocol.stimulus = study::StimulusForm::stroke; // in free space
    EXPECT_EQ(kept_out(protocol, 46.0), "");
    protocol.stimulus = study::StimulusForm::press;
    protocol.responses = {ResponseDevice::keyboard, {"up", "down"}};
    EXPECT_EQ(kept_out(protocol), "");
}

TEST(PersonChecks, FindWhatCannotBeAdjustedWhileItIsFelt) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    protocol.variable.parameter = "press_N";
    EXPECT_EQ(said_of(protocol), "") << "it is no adjustment";
    protocol.task.kind = study::TaskKind::adjustment;
    EXPECT_NE(kept_out(protocol).find("press_N, which cannot be adjusted"), std::string::npos);
    protocol.variable.parameter = "eta";
    EXPECT_EQ(kept_out(protocol), "");
}

/// A line of instructions takes at least 1/36 of the height, so that no more than 36 fit.
TEST(PersonChecks, FindTextsThatAreTooLongToRead) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    const auto warning = [&] {
        const std::string said = said_of(protocol);
        return said.substr(0, said.find(": does not fit"));
    };
    std::string lines = "a";
    for (int count = 1; count < 37; ++count) {
        lines += "\na";
    }
    protocol.texts.instructions = lines.substr(0, 29); // 15 lines: less than half
    EXPECT_EQ(warning(), "");
    protocol.texts.instructions = lines;
    EXPECT_EQ(warning(), "warning: texts.instructions");
    EXPECT_EQ(kept_out(protocol), "");
    protocol.texts.instructions = "a";
    protocol.questionnaire[0].text = lines;
    EXPECT_EQ(warning(), "warning: questions.hand");
}

class StudyLiveCharts : public testing::ImGuiFrame {
protected:
    StudyLiveCharts() {
        // Right above a level of 0.1, wrong below it.
        contents_ = testing::conducted(protocol_, [](const study::PlannedTrial &planned) {
            study::Trial result(planned);
            const bool is_felt = *planned.level > 0.1;
            result.response = study::Chosen{is_felt ? *planned.target : 3 - *planned.target};
            return result;
        });
    }

    /// Waits for it, as frames would.
    const study::SeriesResult *fitted(const std::string &participant, std::size_t condition) {
        fit_.request(contents_, participant, condition, study::DeviceKind::simulated);
        for (int i = 0; i < 6000 && fit_.latest() == nullptr; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        return fit_.latest();
    }

    /// Texts and kinds of what is drawn of it.
    std::string drawn(const study::SeriesResult &result) {
        ui::report().begin(true);
        ImGui::SetNextWindowSize({900.0F, 400.0F});
        ImGui::Begin("charts");
        draw_live_charts(protocol_, result);
        ImGui::End();
        std::string all;
        for (const ShownItem &item : ui::report().items()) {
            all += item.id + " " + item.text + "\n";
        }
        return all;
    }

    study::Protocol protocol_ =
        study::read_protocol_file(testing::assets() / "protocols" / "stiffness.toml");
    study::StudyContents contents_;
    LiveFit fit_{protocol_};
};

TEST_F(StudyLiveCharts, ShowTheCourseAndTheFunctionOfThePresentCondition) {
    const study::SeriesResult *const result = fitted("P01", 1);
    ASSERT_NE(result, nullptr);
    const auto of_condition = std::ranges::count_if(contents_.trials, [&](const auto &trial) {
        return trial.condition == protocol_.conditions[1].name && study::counts(trial);
    });
    EXPECT_EQ(std::ssize(result->trace), of_condition);
    ASSERT_TRUE(result->fitted);
    // The step of the answers at 0.1 lies between the levels of the staircase about it.
    EXPECT_GT(result->fitted->threshold.median, 0.05);
    EXPECT_LT(result->fitted->threshold.median, 0.2);
    const std::string shown = drawn(*result);
    EXPECT_NE(shown.find("levels"), std::string::npos) << shown;
    EXPECT_NE(shown.find("function"), std::string::npos) << shown;
    EXPECT_NE(shown.find(ui::formatted("threshold {:.3g}", result->fitted->threshold.median)),
              std::string::npos)
        << shown;
}

TEST_F(StudyLiveCharts, AreEmptyForWhomNothingIsStored) {
    EXPECT_EQ(fit_.latest(), nullptr);
    fit_.request(contents_, "P02", 0, study::DeviceKind::simulated);
    EXPECT_EQ(fit_.latest(), nullptr);
    fit_.request(contents_, "P01", 0, study::DeviceKind::usb); // there is none on that device
    EXPECT_EQ(fit_.latest(), nullptr);
}

} // namespace
} // namespace springdrive::app::study_screen

// Covers engine/study/protocol/{protocol,study_setting,session_plan,texts}.cpp and the German texts
// of docs/direction_de.toml. What questions are refused in files is in protocol_file_test.cpp.
#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/haptic_law.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/session_plan.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/protocol/texts.h"
#include "tests/engine/study/protocol/plain_protocol.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {
namespace {

using testing::kPlainProtocol;
using testing::protocol_of;
using testing::with;

TEST(ConditionParameters, HaveNamesOfTheirOwnAndDefaultsInRange) {
    std::set<std::string_view> names;
    for (const ParameterFacts &one : condition_parameters()) {
        EXPECT_TRUE(names.insert(one.name).second) << one.name;
        EXPECT_LE(one.minimum, one.default_value) << one.name;
        EXPECT_GE(one.maximum, one.default_value) << one.name;
        EXPECT_EQ(condition_parameter_named(one.name), &one);
        Condition condition;
        one.set(condition, one.maximum);
        EXPECT_EQ(one.get(condition), one.maximum);
    }
    EXPECT_EQ(names.size(), control::kParameters.size() + kConditionParameters.size());
    EXPECT_EQ(condition_parameter_named("eta_"), nullptr);
}

TEST(Turn, OfALevelSurfaceLeansTowardsTheUserAndToTheRight) {
    Condition condition;
    condition.turn_deg = 30.0;
    const double half = 0.5;
    const double root = std::sqrt(0.75);
    EXPECT_TRUE(turned(condition, Vector3::UnitY()).isApprox(Vector3(0.0, root, half), 1e-12));
    condition.turn_axis_deg = 90.0;
    EXPECT_TRUE(turned(condition, Vector3::UnitY()).isApprox(Vector3(half, root, 0.0), 1e-12));
    condition.turn_axis_deg = 180.0;
    EXPECT_TRUE(turned(condition, Vector3::UnitY()).isApprox(Vector3(0.0, root, -half), 1e-12));
}

TEST(Turn, IsByItsAngleWhateverNormalAndAxis) {
    for (const Vector3 &way : {Vector3(0.36, 0.8, 0.48), Vector3(1.0, 0.0, 0.0),
                               Vector3(-1.0, 1e-3, 0.0), Vector3(0.0, 0.0, -1.0)}) {
        const Vector3 normal = way.normalized();
        for (double axis_deg = -180.0; axis_deg <= 180.0; axis_deg += 30.0) {
            const Vector3 axis = turn_axis(normal, axis_deg);
            EXPECT_NEAR(axis.norm(), 1.0, 1e-12);
            EXPECT_NEAR(axis.dot(normal), 0.0, 1e-12);
            Condition condition;
            condition.turn_axis_deg = axis_deg;
            condition.turn_deg = 25.0;
            const Vector3 force = turned(condition, normal);
            EXPECT_NEAR(std::acos(force.dot(normal)), 25.0 * kRadiansPerDegree, 1e-9);
            EXPECT_NEAR(force.dot(axis), 0.0, 1e-12);
        }
    }
}

TEST(Levels, AreTheValueOrAddedOrTakenOff) {
    Protocol protocol = protocol_of(kPlainProtocol);
    EXPECT_DOUBLE_EQ(value_at(protocol, 0.1), 0.5);
    EXPECT_DOUBLE_EQ(comparison(protocol, 1, 0.1).tuning.eta, 0.5);
    EXPECT_EQ(comparison(protocol, 1, 0.1).press_N, 0.8);
    EXPECT_EQ(standard(protocol, 1).tuning.eta, 0.4);
    EXPECT_EQ(standard(protocol, 1).press_N, 0.8);
    protocol.variable.level = LevelMeaning::taken_off;
    EXPECT_DOUBLE_EQ(value_at(protocol, 0.1), 0.3);
    protocol.variable.level = LevelMeaning::value;
    EXPECT_EQ(value_at(protocol, 0.1), 0.1);
    protocol.variable.standard_condition = "a";
    EXPECT_EQ(standard(protocol, 1).press_N, 1.0) << "that of the condition a";
    EXPECT_EQ(standard(protocol, 1).tuning.eta, 0.4);
}

TEST(Levels, OfPlacesAreDirectionsAllAround) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.variable = {"turn_deg", LevelMeaning::value, 0.0, "", false};
    protocol.task = {TaskKind::forced_choice_by_place, 2, 0.5};
    protocol.conditions[0].turn_axis_deg = 90.0;
    const Vector3 up = Vector3::UnitY();
    const Vector3 right = turned(comparison(protocol, 0, 30.0, 0), up);
    const Vector3 left = turned(comparison(protocol, 0, 30.0, 1), up);
    EXPECT_TRUE(right.isApprox(Vector3(0.5, std::sqrt(0.75), 0.0), 1e-12));
    EXPECT_TRUE(left.isApprox(Vector3(-0.5, std::sqrt(0.75), 0.0), 1e-12));
    for (int target = 0; target < 2; ++target) {
        EXPECT_LE(std::abs(comparison(protocol, 0, 30.0, target).turn_axis_deg), 180.0);
    }
}

TEST(Levels, ThatCanBePresentedAreThoseOfMethodPracticeAndCatchTrials) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.practice.levels = {0.35};
    protocol.catch_trials.levels = {0.4};
    EXPECT_EQ(presentable_levels(protocol), (std::vector{0.1, 0.2, 0.3, 0.35, 0.4}));
    protocol.practice.max_trials = 0;
    protocol.catch_trials.one_in = 0;
    EXPECT_EQ(presentable_levels(protocol), (std::vector{0.1, 0.2, 0.3}));

    Staircases up_down;
    up_down.scale = Scale::logarithmic;
    up_down.start_levels = {0.3};
    up_down.minimum_level = 0.01;
    up_down.maximum_level = 0.16;
    protocol.method = up_down;
    const std::vector<double> steps = presentable_levels(protocol, 4);
    const std::vector<double> expected{0.01, 0.02, 0.04, 0.08, 0.16, 0.3};
    ASSERT_EQ(steps.size(), expected.size());
    for (std::size_t i = 0; i < steps.size(); ++i) {
        EXPECT_NEAR(steps[i], expected[i], 1e-12);
    }
    EXPECT_EQ(steps.front(), 0.01) << "to the bit";
    EXPECT_EQ(steps[4], 0.16);
}

/// The claim of protocol.h on which the whole of it rests.
TEST(FreeSpaceTuning, IsTheSameForEveryGainMapAndEta) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const control::HapticLaw law(device);
    const Vector3 q_rad(0.2, 0.35, -0.3);
    const control::Configuration now = law.configuration(
        device::motor_from_joint(device.geometry, q_rad), Vector3(3.0, -5.0, 7.0));
    contact::Contact free;
    free.x0_m = now.tip_m;
    control::Tuning tuning;
    const Vector3 expected_V = law.k_T().cwiseProduct(now.theta_rate_rad_per_s);
    for (const control::MotionMap map :
         {control::MotionMap::inverse, control::MotionMap::transpose}) {
        for (const double gain : {0.0, 1.0, 20.0}) {
            for (const double eta : {0.0, 0.5, 1.0}) {
                tuning.map = map;
                tuning.K_P_V_per_rad = 6.0 * gain;
                tuning.K_D_Vs_per_rad = 0.01 * gain;
                tuning.eta = eta;
                const Vector3 e_W_V = law(now, free, tuning, {}).command.e_W_V;
                EXPECT_TRUE(e_W_V.isApprox(expected_V, 1e-9)) << e_W_V.transpose();
            }
        }
    }
}

TEST(FreeSpaceTuning, OfAnotherServoRateHasTheSameLag) {
    Protocol protocol = protocol_of(kPlainProtocol);
    for (const double servo_hz : {800.0, 1000.0, 4000.0, 10'000.0}) {
        Condition condition = protocol.conditions[0];
        condition.servo_hz = servo_hz;
        condition.tuning.dR_Ohm = 0.2;
        const std::optional<control::Tuning> free = free_space_tuning(protocol, condition);
        ASSERT_TRUE(free) << servo_hz;
        EXPECT_EQ(free->dR_Ohm, 0.5);
        // τ = T (a/(1 − a) + 1 + d), by hand: at 1 kHz with λ 1000 rad/s a is 1/e.
        const double T = 1.0 / servo_hz;
        const double a = std::exp(-free->lambda_rad_per_s * T);
        EXPECT_NEAR(T * (a / (1.0 - a) + 1.0), 1e-3 * (1.0 / (std::exp(1.0) - 1.0) + 1.0), 1e-15);
    }
    Condition slow = protocol.conditions[0];
    slow.servo_hz = 633.0; // T above the lag, 1.582 ms
    EXPECT_TRUE(free_space_tuning(protocol, slow));
    slow.servo_hz = 632.0;
    EXPECT_FALSE(free_space_tuning(protocol, slow));
    protocol.free_space.reset();
    EXPECT_EQ(free_space_tuning(protocol, slow), slow.tuning);
}

TEST(Presented, AreTheStandardAndAllLevelsOfConditionsInUse) {
    Protocol protocol = protocol_of(kPlainProtocol);
    const std::vector<Presented> all = all_presented(protocol);
    ASSERT_EQ(all.size(), 8U);
    EXPECT_FALSE(all[0].level);
    EXPECT_EQ(all[0].parameters.tuning.eta, 0.4);
    EXPECT_EQ(all[3].level, 0.3);
    EXPECT_EQ(all[4].condition, 1U);
    const std::vector<Presented> ends = extremes(all);
    ASSERT_EQ(ends.size(), 6U);
    EXPECT_EQ(ends[1].level, 0.1);
    EXPECT_EQ(ends[2].level, 0.3);

    protocol.blocks.pop_back();
    EXPECT_FALSE(is_used(protocol, 1));
    EXPECT_EQ(all_presented(protocol).size(), 4U);
    protocol.variable.standard_condition = "b";
    EXPECT_TRUE(is_used(protocol, 1));
    EXPECT_EQ(all_presented(protocol).size(), 4U) << "b as the standard, a at three levels";
}

TEST(SessionLength, AddsUpTrialsAndBreaks) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.timing = {0.5, 1.0, 1.0, 0.5, 5.0, 1.0, 1.0};
    protocol.questionnaire.clear(); // see ProtocolCheck.QuestionsCountInTheSession
    // rest 0.5, two intervals of (0.5 to 1) + 1, pause 0.5, response 1, between trials 1
    EXPECT_DOUBLE_EQ(usual_trial_s(protocol), 6.0);
    EXPECT_DOUBLE_EQ(long_trial_s(protocol), 7.0);
    protocol.breaks = {20, 60.0, 120.0};
    const SessionLength length = session_length(protocol);
    // 30 measured trials, one catch trial to nine of them, in the first block 2 to 4 of practice.
    EXPECT_EQ(length.blocks[0].min_trials, 35);
    EXPECT_EQ(length.blocks[1].min_trials, 33);
    EXPECT_DOUBLE_EQ(length.min_s, (35 + 33) * 6.0 + 2 * 60.0 + 120.0);
    EXPECT_DOUBLE_EQ(length.longest_without_break_s, 20 * 7.0);
    protocol.breaks.every_trials = 0;
    EXPECT_DOUBLE_EQ(session_length(protocol).min_s, (35 + 33) * 6.0 + 120.0);
}

/// Every order of right and wrong answers, played by the method itself, against the bound.
TEST(SessionLength, NoTrackOfAStaircaseEndsBeforeItsFewestTrials) {
    Staircases up_down;
    up_down.start_levels = {0.5};
    up_down.correct_for_down = 2;
    up_down.reversals = 3;
    up_down.trials = 12;
    up_down.steps = {{0, 0.05}};
    int shortest = up_down.trials;
    for (unsigned answers = 0; answers < 1U << 12U; ++answers) {
        MethodRun run(up_down, RandomKey{1});
        int trials = 0;
        while (const std::optional<MethodTrial> trial = run.next()) {
            const bool right = (answers >> static_cast<unsigned>(trials) & 1U) != 0;
            run.add({*trial, {right, 0.0, false}});
            ++trials;
        }
        shortest = std::min(shortest, trials);
    }
    EXPECT_EQ(min_trials(up_down), shortest);
}

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

/// The German texts beside the page are complete, and a shipped protocol may have them.
TEST(Texts, TheManualHasThemInGerman) {
    const std::string german =
        testing::contents_of(testing::assets().parent_path() / "docs/direction_de.toml");
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

TEST(Questionnaire, AScaleTakesItsWholeNumbersAndAChoiceItsTexts) {
    for (const QuestionnaireItem &item :
         testing::protocol_of(testing::kPlainProtocol).questionnaire) {
        EXPECT_EQ(validate(item), "");
    }
    EXPECT_EQ(possible_answers(scale(-1, 1)), (std::vector<std::string>{"-1", "0", "1"}));
    EXPECT_EQ(possible_answers(scale(0, kMaxScaleSteps)).size(), 101U);
    EXPECT_EQ(possible_answers(choice()), choice().choices);
}

} // namespace
} // namespace springdrive::study

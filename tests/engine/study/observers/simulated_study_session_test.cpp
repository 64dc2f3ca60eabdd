// Covers engine/study/observers: what is perceived, what is answered (frequencies against the
// function, within the deviations of a binomial), and sessions through the simulated device.
#include "engine/study/conduct/conduct.h"
#include "engine/study/observers/simulated_study_session.h"
#include "tests/engine/study/protocol/plain_protocol.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace springdrive::study {
namespace {

using testing::kPlainProtocol;
using testing::protocol_of;

FeltPresentation felt_with(double intended_N_per_m, double delivered_N_per_m) {
    FeltPresentation felt;
    felt.intended.stiffness_N_per_m = intended_N_per_m;
    felt.delivered.stiffness_N_per_m = delivered_N_per_m;
    return felt;
}

Protocol of_variable(const std::string &parameter) {
    Protocol protocol = testing::protocol_of(testing::kPlainProtocol);
    protocol.variable.parameter = parameter;
    protocol.variable.level = LevelMeaning::value;
    return protocol;
}

TEST(PerceivedLevel, IsWhatGivesTheDeliveredStiffnessOrWasMeasured) {
    constexpr double kRigid = 2000.0;
    FeltPresentation eta = felt_with((1.0 - 0.4) * kRigid, (1.0 - 0.43) * kRigid);
    eta.condition.tuning.eta = 0.4;
    EXPECT_NEAR(delivered_value(of_variable("eta"), eta), 0.43, 1e-12);
    eta.delivered.stiffness_N_per_m.reset();
    EXPECT_EQ(delivered_value(of_variable("eta"), eta), 0.4) << "as intended where not measured";

    FeltPresentation felt = felt_with(1000.0, 1050.0); // K is k_T K_P/dR
    felt.condition.tuning.K_P_V_per_rad = 6.0;
    felt.condition.tuning.dR_Ohm = 0.42;
    felt.condition.turn_deg = 20.0;
    felt.condition.pulse_N = 1.0;
    felt.delivered.turn_deg = 19.4;
    felt.delivered.pulse_N = 0.93;
    for (const auto &[variable, value] :
         {std::pair("K_P_V_per_rad", 6.3),
          {"dR_Ohm", 0.4},
          {"turn_deg", 19.4},
          {"pulse_N", 0.93},
          {"lambda_rad_per_s", felt.condition.tuning.lambda_rad_per_s}}) {
        EXPECT_NEAR(delivered_value(of_variable(variable), felt), value, 1e-12) << variable;
    }
}

TEST(PerceivedLevel, IsTheDifferenceFromTheStandardAsDelivered) {
    Protocol protocol = of_variable("turn_deg");
    FeltPresentation comparison;
    comparison.delivered.turn_deg = 21.0;
    FeltPresentation standard;
    standard.delivered.turn_deg = 5.5;
    EXPECT_EQ(delivered_level(protocol, comparison, standard), 21.0);
    protocol.variable.level = LevelMeaning::added;
    protocol.variable.standard = 5.0;
    EXPECT_EQ(delivered_level(protocol, comparison, standard), 15.5);
    EXPECT_EQ(delivered_level(protocol, comparison, std::nullopt), 16.0);
    protocol.variable.level = LevelMeaning::taken_off;
    EXPECT_EQ(delivered_level(protocol, comparison, standard), -15.5);
}

constexpr int kTrials = 20'000;
constexpr double kDeviations = 4.0; ///< beyond these one seed of 16,000 falls

Protocol with_task(TaskKind kind, int alternatives) {
    Protocol protocol = testing::protocol_of(testing::kPlainProtocol);
    protocol.task.kind = kind;
    protocol.task.alternatives = alternatives;
    return protocol;
}

SimulatedParticipant observer(double guess) {
    SimulatedParticipant participant;
    participant.function = {{Shape::weibull, Scale::logarithmic}, 2.0, 3.0, guess, 0.04};
    participant.seed = 5;
    return participant;
}

PlannedTrial planned(int number, int target) {
    PlannedTrial trial;
    trial.seed = child(RandomKey{77}, static_cast<std::uint64_t>(number)).bits;
    trial.target = target + 1;
    return trial;
}

/// Within the standard deviations of so many draws.
void expect_share(int count, double share) {
    EXPECT_NEAR(static_cast<double>(count) / kTrials, share,
                kDeviations * std::sqrt(share * (1.0 - share) / kTrials));
}

TEST(SimulatedAnswer, IsRightAsOftenAsTheFunctionSaysAndElseAnyOther) {
    const Protocol protocol = with_task(TaskKind::forced_choice_by_interval, 4);
    const SimulatedParticipant participant = observer(0.25);
    for (const double level : {-1.0, 0.0, 1.0, 2.0, 10.0}) {
        std::array<int, 4> chosen{};
        for (int i = 0; i < kTrials; ++i) {
            const SimulatedAnswer answer =
                simulated_answer(protocol, participant, planned(i, 2), level);
            ++chosen[static_cast<std::size_t>(std::get<Chosen>(answer.response).alternative - 1)];
        }
        // Weibull's, written out.
        const double core = level > 0.0 ? 1.0 - std::exp(-std::pow(level / 2.0, 3.0)) : 0.0;
        const double right = 0.25 + (1.0 - 0.25 - 0.04) * core;
        expect_share(chosen[2], right);
        for (const std::size_t wrong : {0U, 1U, 3U}) {
            expect_share(chosen[wrong], (1.0 - right) / 3.0);
        }
    }
}

TEST(SimulatedAnswer, SaysYesAsOftenAsTheFunctionSaysAndMoreWithABias) {
    const Protocol protocol = with_task(TaskKind::yes_no, 2);
    for (const double bias : {-0.3, 0.0, 0.3}) {
        SimulatedParticipant participant = observer(0.1);
        participant.bias = bias;
        int yes = 0;
        for (int i = 0; i < kTrials; ++i) {
            yes += std::get<YesNo>(
                       simulated_answer(protocol, participant, planned(i, 0), 2.0).response)
                           .yes
                       ? 1
                       : 0;
        }
        const double function = 0.1 + (1.0 - 0.1 - 0.04) * (1.0 - std::exp(-1.0));
        expect_share(yes, (1.0 - std::abs(bias)) * function + std::max(0.0, bias));
    }
}

TEST(SimulatedAnswer, TakesItsTimeAndMayBeTooLate) {
    Protocol protocol = with_task(TaskKind::forced_choice_by_interval, 2);
    SimulatedParticipant participant = observer(0.5);
    participant.response_median_s = 0.8;
    participant.response_spread = 0.5;
    protocol.timing.response_s = 0.8 * std::exp(0.5); // one deviation: 15.87 % are later
    int late = 0;
    int quick = 0;
    for (int i = 0; i < kTrials; ++i) {
        const SimulatedAnswer answer = simulated_answer(protocol, participant, planned(i, 0), 2.0);
        late += answer.response_time_s ? 0 : 1;
        EXPECT_EQ(std::holds_alternative<NoResponse>(answer.response), !answer.response_time_s);
        quick += answer.response_time_s.value_or(10.0) < 0.8 ? 1 : 0;
    }
    expect_share(late, 0.158655);
    expect_share(quick, 0.5);
}

TEST(SimulatedAnswer, SetsAnAdjustmentAboutTheThreshold) {
    Protocol protocol = with_task(TaskKind::adjustment, 2);
    Adjustment method;
    method.minimum_level = 0.0;
    method.maximum_level = 100.0;
    protocol.method = method;
    SimulatedParticipant participant = observer(0.0);
    participant.function.family = {Shape::cumulative_normal, Scale::linear};
    participant.function.threshold = 3.0;
    participant.function.slope = 2.0; // deviation 0.5
    int below_one = 0;
    int below_mean = 0;
    for (int i = 0; i < kTrials; ++i) {
        const double level =
            std::get<Adjusted>(simulated_answer(protocol, participant, planned(i, 0), 1.0).response)
                .level;
        below_mean += level < 3.0 ? 1 : 0;
        below_one += level < 2.5 ? 1 : 0;
    }
    expect_share(below_mean, 0.5);
    expect_share(below_one, 0.158655);
}

TEST(SimulatedAnswer, IsAFunctionOfTrialAndParticipantAlone) {
    const Protocol protocol = with_task(TaskKind::forced_choice_by_interval, 2);
    SimulatedParticipant one = observer(0.5);
    SimulatedParticipant other = one;
    other.seed = 6;
    int different = 0;
    for (int i = 0; i < 1000; ++i) {
        const SimulatedAnswer answer = simulated_answer(protocol, one, planned(i, 0), 1.0);
        EXPECT_EQ(answer.response, simulated_answer(protocol, one, planned(i, 0), 1.0).response);
        different +=
            answer.response == simulated_answer(protocol, other, planned(i, 0), 1.0).response ? 0
                                                                                              : 1;
    }
    EXPECT_GT(different, 100);
}

Protocol direction_protocol() {
    Protocol protocol = protocol_of(kPlainProtocol);
    for (Condition &condition : protocol.conditions) {
        condition.hold = Hold::cup;
        condition.turn_axis_deg = 90.0;
    }
    protocol.variable.parameter = "turn_deg";
    protocol.variable.level = LevelMeaning::value;
    protocol.variable.standard = 0.0;
    std::get<ConstantStimuli>(protocol.method).levels = {5.0, 20.0, 40.0};
    protocol.practice = {};
    protocol.catch_trials = {};
    return protocol;
}

SimulatedStudySession study_session_of(const Protocol &protocol,
                                       FeltStimuli felt = FeltStimuli::each_simulated) {
    SimulatedParticipant participant;
    participant.function.threshold = 20.0;
    participant.function.slope = 3.0;
    return {protocol, study_setting(protocol, testing::folders()), participant, felt};
}

PlannedTrial trial_at(double level, int target, int number) {
    PlannedTrial planned;
    planned.condition = "a";
    planned.level = level;
    planned.target = target + 1;
    planned.seed = child(RandomKey{3}, static_cast<std::uint64_t>(number)).bits;
    return planned;
}

std::optional<double> delivered(const Presentation &presentation, const std::string &name) {
    const auto found = std::ranges::find(presentation.values, name, &StimulusValue::name);
    return found == presentation.values.end() ? std::nullopt : found->delivered;
}

TEST(SimulatedStudySession, PresentsTheComparisonInItsInterval) {
    const Protocol protocol = direction_protocol();
    SimulatedStudySession study_session = study_session_of(protocol);
    for (const int target : {0, 1}) {
        const Trial result = study_session.present(trial_at(40.0, target, 1)).value();
        ASSERT_EQ(result.presentations.size(), 2U);
        const auto at = static_cast<std::size_t>(target);
        EXPECT_NEAR(delivered(result.presentations[at], "direction_deg").value(), 40.0, 1.0);
        EXPECT_NEAR(delivered(result.presentations[1 - at], "direction_deg").value(), 0.0, 1.0);
        EXPECT_TRUE(marks_of(protocol.marking, result.presentations).empty());
        EXPECT_TRUE(result.marks.empty());
        EXPECT_TRUE(result.safety_events.empty());
        EXPECT_LT(*result.presentations[0].end_s, *result.presentations[1].start_s);
        EXPECT_EQ(result.windings_degC.size(), 3U);
    }
}

TEST(SimulatedStudySession, IsTheSameInWhateverOrderAndByWhomeverItIsAsked) {
    const Protocol protocol = direction_protocol();
    SimulatedStudySession one = study_session_of(protocol);
    SimulatedStudySession resumed = study_session_of(protocol);
    const Trial first = one.present(trial_at(20.0, 0, 1)).value();
    const Trial second = one.present(trial_at(5.0, 1, 2)).value();
    const Trial second_again = resumed.present(trial_at(5.0, 1, 2)).value();
    const Trial first_again = resumed.present(trial_at(20.0, 0, 1)).value();
    EXPECT_EQ(first.presentations, first_again.presentations);
    EXPECT_EQ(first.response, first_again.response);
    EXPECT_EQ(second.presentations, second_again.presentations);
    EXPECT_EQ(second.response_time_s, second_again.response_time_s);
    EXPECT_NE(first.presentations[1].values, second.presentations[0].values)
        << "hands are different";
}

TEST(SimulatedStudySession, StimuliMeasuredOnceAreTheSameEachTime) {
    const Protocol protocol = direction_protocol();
    SimulatedStudySession study_session = study_session_of(protocol, FeltStimuli::measured_once);
    const Trial first = study_session.present(trial_at(20.0, 0, 1)).value();
    const Trial other = study_session.present(trial_at(20.0, 0, 2)).value();
    EXPECT_EQ(first.presentations, other.presentations);
    EXPECT_NE(first.response_time_s, other.response_time_s);
}

TEST(SimulatedStudySession, OfAForcedChoiceByPlaceThePlaceIsTheDirection) {
    Protocol protocol = direction_protocol();
    protocol.task.kind = TaskKind::forced_choice_by_place;
    SimulatedStudySession study_session = study_session_of(protocol, FeltStimuli::measured_once);
    for (const int target : {0, 1}) {
        const Trial result = study_session.present(trial_at(40.0, target, 1)).value();
        ASSERT_EQ(result.presentations.size(), 1U);
        EXPECT_NEAR(delivered(result.presentations[0], "direction_deg").value(), 40.0, 1.0);
    }
}

TEST(SimulatedStudySession, ShowsTheStandardFirstWhereTheProtocolWantsIt) {
    Protocol protocol = direction_protocol();
    protocol.task.kind = TaskKind::yes_no;
    EXPECT_EQ(study_session_of(protocol).present(trial_at(40.0, 0, 1))->presentations.size(), 1U);
    protocol.variable.shows_standard = true;
    const Trial result = study_session_of(protocol).present(trial_at(40.0, 0, 1)).value();
    ASSERT_EQ(result.presentations.size(), 2U);
    EXPECT_NEAR(delivered(result.presentations[0], "direction_deg").value(), 0.0, 1.0);
    EXPECT_NEAR(delivered(result.presentations[1], "direction_deg").value(), 40.0, 1.0);
    EXPECT_TRUE(std::holds_alternative<YesNo>(result.response));
}

TEST(SimulatedStudySession, WarmsTheWindingsFirstAndAgainWhenTheyAreCold) {
    Protocol protocol = direction_protocol();
    SimulatedStudySession study_session = study_session_of(protocol, FeltStimuli::measured_once);
    EXPECT_EQ(study_session.warm_up_s(), 0.0);
    const Trial first = study_session.present(trial_at(20.0, 0, 1)).value();
    const double once_s = study_session.warm_up_s();
    EXPECT_GT(once_s, 10.0);
    for (const std::optional<double> &winding_C : first.windings_degC) {
        EXPECT_GE(winding_C.value(), protocol.windings.from_C);
        EXPECT_LE(winding_C.value(), protocol.windings.to_C);
    }
    static_cast<void>(study_session.present(trial_at(20.0, 0, 2)).value());
    EXPECT_EQ(study_session.warm_up_s(), once_s) << "still in the band";

    // Half an hour between trials: three times the motors' time constant.
    protocol.timing.between_trials_s = 1800.0;
    SimulatedStudySession slow = study_session_of(protocol, FeltStimuli::measured_once);
    static_cast<void>(slow.present(trial_at(20.0, 0, 1)).value());
    const Trial later = slow.present(trial_at(20.0, 0, 2)).value();
    EXPECT_GT(slow.warm_up_s(), 1.5 * once_s);
    for (const std::optional<double> &winding_C : later.windings_degC) {
        EXPECT_GE(winding_C.value(), protocol.windings.from_C);
    }
    EXPECT_EQ(later.presentations, first.presentations) << "whatever came before";
}

TEST(SimulatedStudySession, TellsOfATripAsASafetyEvent) {
    const Protocol protocol = direction_protocol();
    StudySetting setting = study_setting(protocol, testing::folders());
    setting.device.limits.tip_speed_m_per_s = 0.01;
    SimulatedStudySession study_session(protocol, setting, SimulatedParticipant{});
    const Trial result = study_session.present(trial_at(20.0, 0, 1)).value();
    ASSERT_FALSE(result.safety_events.empty());
    EXPECT_NE(result.safety_events[0].text.find("tip speed"), std::string::npos);
}

} // namespace
} // namespace springdrive::study

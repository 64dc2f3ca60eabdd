// Covers engine/study/observers/simulated_answer.cpp: frequencies against the function, within the
// deviations of a binomial.
#include "engine/study/observers/simulated_answer.h"

#include "tests/engine/study/protocol/plain_protocol.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace springdrive::study {
namespace {

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

} // namespace
} // namespace springdrive::study

// Covers engine/study/observers/simulated_sitting.cpp: sessions through the simulated device.
#include "engine/study/observers/simulated_sitting.h"

#include "engine/study/conduct/marking.h"
#include "engine/study/conduct/sequence.h"
#include "tests/engine/study/protocol/plain_protocol.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace springdrive::study {
namespace {

using testing::kPlainProtocol;
using testing::protocol_of;

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

SimulatedSitting sitting_of(const Protocol &protocol,
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

TEST(SimulatedSitting, PresentsTheComparisonInItsInterval) {
    const Protocol protocol = direction_protocol();
    SimulatedSitting sitting = sitting_of(protocol);
    for (const int target : {0, 1}) {
        const Trial result = sitting.present(trial_at(40.0, target, 1)).value();
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

TEST(SimulatedSitting, IsTheSameInWhateverOrderAndByWhomeverItIsAsked) {
    const Protocol protocol = direction_protocol();
    SimulatedSitting one = sitting_of(protocol);
    SimulatedSitting resumed = sitting_of(protocol);
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

TEST(SimulatedSitting, StimuliMeasuredOnceAreTheSameEachTime) {
    const Protocol protocol = direction_protocol();
    SimulatedSitting sitting = sitting_of(protocol, FeltStimuli::measured_once);
    const Trial first = sitting.present(trial_at(20.0, 0, 1)).value();
    const Trial other = sitting.present(trial_at(20.0, 0, 2)).value();
    EXPECT_EQ(first.presentations, other.presentations);
    EXPECT_NE(first.response_time_s, other.response_time_s);
}

TEST(SimulatedSitting, OfAForcedChoiceByPlaceThePlaceIsTheDirection) {
    Protocol protocol = direction_protocol();
    protocol.task.kind = TaskKind::forced_choice_by_place;
    SimulatedSitting sitting = sitting_of(protocol, FeltStimuli::measured_once);
    for (const int target : {0, 1}) {
        const Trial result = sitting.present(trial_at(40.0, target, 1)).value();
        ASSERT_EQ(result.presentations.size(), 1U);
        EXPECT_NEAR(delivered(result.presentations[0], "direction_deg").value(), 40.0, 1.0);
    }
}

TEST(SimulatedSitting, ShowsTheStandardFirstWhereTheProtocolWantsIt) {
    Protocol protocol = direction_protocol();
    protocol.task.kind = TaskKind::yes_no;
    EXPECT_EQ(sitting_of(protocol).present(trial_at(40.0, 0, 1))->presentations.size(), 1U);
    protocol.variable.shows_standard = true;
    const Trial result = sitting_of(protocol).present(trial_at(40.0, 0, 1)).value();
    ASSERT_EQ(result.presentations.size(), 2U);
    EXPECT_NEAR(delivered(result.presentations[0], "direction_deg").value(), 0.0, 1.0);
    EXPECT_NEAR(delivered(result.presentations[1], "direction_deg").value(), 40.0, 1.0);
    EXPECT_TRUE(std::holds_alternative<YesNo>(result.response));
}

TEST(SimulatedSitting, WarmsTheWindingsFirstAndAgainWhenTheyAreCold) {
    Protocol protocol = direction_protocol();
    SimulatedSitting sitting = sitting_of(protocol, FeltStimuli::measured_once);
    EXPECT_EQ(sitting.warm_up_s(), 0.0);
    const Trial first = sitting.present(trial_at(20.0, 0, 1)).value();
    const double once_s = sitting.warm_up_s();
    EXPECT_GT(once_s, 10.0);
    for (const std::optional<double> &winding_C : first.windings_degC) {
        EXPECT_GE(winding_C.value(), protocol.windings.from_C);
        EXPECT_LE(winding_C.value(), protocol.windings.to_C);
    }
    static_cast<void>(sitting.present(trial_at(20.0, 0, 2)).value());
    EXPECT_EQ(sitting.warm_up_s(), once_s) << "still in the band";

    // Half an hour between trials: three times the motors' time constant.
    protocol.timing.between_trials_s = 1800.0;
    SimulatedSitting slow = sitting_of(protocol, FeltStimuli::measured_once);
    static_cast<void>(slow.present(trial_at(20.0, 0, 1)).value());
    const Trial later = slow.present(trial_at(20.0, 0, 2)).value();
    EXPECT_GT(slow.warm_up_s(), 1.5 * once_s);
    for (const std::optional<double> &winding_C : later.windings_degC) {
        EXPECT_GE(winding_C.value(), protocol.windings.from_C);
    }
    EXPECT_EQ(later.presentations, first.presentations) << "whatever came before";
}

TEST(SimulatedSitting, TellsOfATripAsASafetyEvent) {
    const Protocol protocol = direction_protocol();
    StudySetting setting = study_setting(protocol, testing::folders());
    setting.device.limits.tip_speed_m_per_s = 0.01;
    SimulatedSitting sitting(protocol, setting, SimulatedParticipant{});
    const Trial result = sitting.present(trial_at(20.0, 0, 1)).value();
    ASSERT_FALSE(result.safety_events.empty());
    EXPECT_NE(result.safety_events[0].text.find("tip speed"), std::string::npos);
}

} // namespace
} // namespace springdrive::study

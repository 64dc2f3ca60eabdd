// Covers app/visitors/curve_of_answers.cpp, and the task's protocol: what it finds of visitors
// whose thresholds are known.
#include "app/visitors/curve_of_answers.h"

#include "engine/study/observers/simulated_sitting.h"
#include "engine/study/protocol/protocol_file.h"
#include "tests/app/study/headless_study.h"
#include "tests/support/cases.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace springdrive::app::visitors {
namespace {

study::Protocol shipped(const std::string &name) {
    return study::read_protocol_file(testing::assets() / "protocols" / (name + ".toml"));
}

/// A whole visit without the hand.
study::StudyContents visit_of(const study::Protocol &protocol,
                              const study::SimulatedParticipant &visitor, int number) {
    const auto present = [&](const study::PlannedTrial &planned) {
        study::Trial result(planned);
        result.response =
            study::simulated_answer(protocol, visitor, planned, *planned.level).response;
        return result;
    };
    return testing::conducted(protocol, present, number);
}

/// Visitors drawn from what the method thinks possible: then a 95 % interval holds 95 of 100, of
/// which 100 draws keep within 89 to 99 with a probability of 0.99 (binomial). The default tests
/// draw 12, of which fewer than 9 have a probability of 0.002; `tests/long visits` all.
TEST(CurveOfAnswers, IntervalHoldsTheThresholdIn95Of100Visits) {
    const study::Protocol protocol = shipped("can_you_feel_it");
    const int visits = testing::cases(12, 100);
    int held = 0;
    std::vector<double> factors; ///< of the intervals, from end to end
    const study::RandomKey key = study::key_of(7, 1);
    for (int i = 0; i < visits; ++i) {
        const auto draw = [&](std::uint64_t which) {
            return study::uniform(
                study::child(study::child(key, static_cast<std::uint64_t>(i)), which));
        };
        study::SimulatedParticipant visitor;
        visitor.function.threshold = 2.0 * std::pow(30.0, draw(0)); // 2 to 60 degrees
        visitor.function.slope = 0.7 * std::pow(10.0, draw(1));     // 0.7 to 7
        visitor.function.lapse = 0.06 * draw(2);
        visitor.seed = static_cast<std::uint64_t>(i) + 1;
        const auto result = result_of_visit(protocol, visit_of(protocol, visitor, i + 1));
        ASSERT_TRUE(result && result->fitted);
        EXPECT_EQ(result->trials, 34);
        const study_screen::OwnCurve curve = curve_of(protocol, result);
        const double threshold = visitor.function.threshold;
        held += threshold >= curve.threshold->low && threshold <= curve.threshold->high ? 1 : 0;
        factors.push_back(curve.threshold->high / curve.threshold->low);
    }
    EXPECT_GE(held, testing::cases(9, 89));
    EXPECT_LE(held, testing::cases(12, 99));
    const auto median = factors.begin() + visits / 2;
    std::ranges::nth_element(factors, median);
    // Not because it says nothing: what is thought possible is a factor of 30.
    EXPECT_LT(*median, 8.0);
    std::printf("counts: %d of %d intervals hold the threshold; from end to end a factor of %.2f "
                "in the median\n",
                held, visits, *median);
}

TEST(CurveOfAnswers, HasADotForEachLevelWithAllAnswers) {
    const study::Protocol protocol = shipped("can_you_feel_it");
    study::SimulatedParticipant visitor;
    visitor.function = {{}, 15.0, 2.0, 0.5, 0.02};
    const study::StudyContents visit = visit_of(protocol, visitor, 1);
    const study_screen::OwnCurve curve = curve_of(protocol, result_of_visit(protocol, visit));
    for (const study_screen::OwnCurve::Dot &dot : curve.dots) {
        int trials = 0;
        int right = 0;
        for (const study::Trial &trial : visit.trials) { // counted anew
            const bool is_meant = !trial.is_practice && trial.level == dot.level;
            trials += is_meant ? 1 : 0;
            right += is_meant && trial.is_correct.value_or(false) ? 1 : 0;
        }
        EXPECT_EQ(dot.trials, trials);
        EXPECT_DOUBLE_EQ(dot.right_share, static_cast<double>(right) / trials);
    }
    EXPECT_TRUE(std::ranges::is_sorted(curve.course, {}, &study_screen::OwnCurve::Point::level));
    EXPECT_EQ(curve.lowest_level, 2.0);
    EXPECT_EQ(curve.highest_level, 60.0);
}

TEST(CurveOfAnswers, SaysTheThresholdInPlainWords) {
    study_screen::OwnCurve curve = curve_of(shipped("can_you_feel_it"), std::nullopt);
    EXPECT_EQ(threshold_words(curve), "");
    curve.threshold = {14.2, 9.4, 21.6};
    EXPECT_EQ(threshold_words(curve), "14 degrees (9 to 22)");
    curve.threshold = {48.0, 31.0, 59.0}; // up to the end: it may be anything beyond
    EXPECT_EQ(threshold_words(curve), "more than 31 degrees");
    curve.threshold = {2.6, 2.05, 4.4};
    EXPECT_EQ(threshold_words(curve), "less than 4 degrees");
    curve.threshold = {20.0, 2.3, 56.0}; // just off both ends
    EXPECT_EQ(threshold_words(curve), "20 degrees (2 to 56)");
}

TEST(CurveOfAnswers, TakesTheVisitorsProtocolAndRefusesOthers) {
    EXPECT_EQ(validate_for_visitors(shipped("can_you_feel_it")), "");
    for (const char *name : {"direction", "stiffness", "blow", "hardness", "mass"}) {
        EXPECT_NE(validate_for_visitors(shipped(name)), "") << name;
    }
    study::Protocol protocol = shipped("can_you_feel_it");
    protocol.variable.parameter = "eta";
    EXPECT_NE(validate_for_visitors(protocol).find("turn_deg"), std::string::npos);
    protocol = shipped("can_you_feel_it");
    protocol.noise = study::MaskingNoise{-30.0};
    EXPECT_NE(validate_for_visitors(protocol).find("[noise]"), std::string::npos);
    protocol = shipped("can_you_feel_it");
    protocol.questionnaire = shipped("direction").questionnaire;
    EXPECT_NE(validate_for_visitors(protocol).find("[[questions]]"), std::string::npos);
}

} // namespace
} // namespace springdrive::app::visitors

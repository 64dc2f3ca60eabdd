// Covers engine/study/analysis/precision_plan.cpp and simulated_study.cpp.
#include "engine/study/analysis/precision_plan.h"
#include "engine/study/analysis/simulated_study.h"
#include "engine/study/analysis/student.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace springdrive::study {
namespace {

PrecisionQuestion question_of_constant_stimuli() {
    PrecisionQuestion question;
    question.method = ConstantStimuli{{0.25, 0.5, 1.0, 2.0, 4.0}, 1, 10};
    question.analysis.threshold = {Scale::logarithmic, 0.1, 10.0};
    question.analysis.slope = {Scale::logarithmic, 0.5, 8.0};
    question.analysis.guess = known(0.5);
    question.analysis.lapse = {Scale::linear, 0.0, 0.06};
    question.observers = question.analysis;
    question.observers.threshold = known(1.0);
    question.observers.threshold.scale = Scale::logarithmic;
    question.observers.slope = known(2.5);
    question.observers.lapse = known(0.02);
    question.trials = {50, 200, 800};
    question.studies = 40;
    return question;
}

TEST(SimulatedStudy, AnswersAsTheFunctionSays) {
    const PsychometricFunction observer{
        {Shape::logistic, Scale::logarithmic}, 2.0, 3.0, 0.25, 0.05};
    constexpr int kTrials = 20'000;
    int positive = 0;
    std::vector<double> settings;
    for (std::uint64_t i = 0; i < kTrials; ++i) {
        const Outcome outcome = answer_of(observer, 2.5, child({21}, i));
        positive += outcome.positive ? 1 : 0;
        settings.push_back(std::log(outcome.setting));
        EXPECT_FALSE(outcome.marked);
    }
    const double p = proportion_at(observer, 2.5);
    EXPECT_NEAR(positive, kTrials * p, 4.0 * std::sqrt(kTrials * p * (1.0 - p)));
    const MeanSummary mean = mean_of(settings);
    EXPECT_NEAR(mean.mean, std::log(2.0), 4.0 * mean.standard_error);
    // The deviation of a deviation is σ/√(2n).
    EXPECT_NEAR(mean.deviation, 1.0 / 3.0, 4.0 / 3.0 / std::sqrt(2.0 * kTrials));
}

TEST(Precision, GrowsWithTheRootOfTheTrials) {
    const std::vector<Precision> rows = precision_by_trials(question_of_constant_stimuli());
    ASSERT_EQ(rows.size(), 3U);
    EXPECT_EQ(rows[1].trials, 200);
    // Of a known slope the width is exactly inverse to the root; the prior's end cuts the first.
    EXPECT_NEAR(rows[1].median_width / rows[2].median_width, 2.0, 0.3);
    EXPECT_GT(rows[0].median_width, 1.3 * rows[1].median_width);
    for (const Precision &row : rows) {
        EXPECT_GE(row.width_of_most, row.median_width);
        EXPECT_GE(row.coverage, 0.8); // of 40 studies, 95 % expected: below by chance once in 3000
        EXPECT_LT(std::abs(row.bias), row.rms_error);
    }
    EXPECT_LT(rows[2].rms_error, 0.5 * rows[0].rms_error);
}

TEST(Precision, OfAnAdjustmentIsStudentsInterval) {
    PrecisionQuestion question = question_of_constant_stimuli();
    question.method = Adjustment{Scale::logarithmic, 0.5, 2.0, 0.01, 100.0, 10};
    question.trials = {5, 20};
    question.studies = 400;
    const std::vector<Precision> rows = precision_by_trials(question);
    // 2 t(0.975; 4)/√5 σ and 2 t(0.975; 19)/√20 σ with σ 0.4, in the median: the sample's deviation
    // is 0.916 and 0.983 σ there.
    EXPECT_NEAR(rows[0].median_width, 2.0 * 2.7764 * 0.916 * 0.4 / std::sqrt(5.0), 0.07);
    EXPECT_NEAR(rows[1].median_width, 2.0 * 2.0930 * 0.983 * 0.4 / std::sqrt(20.0), 0.02);
    EXPECT_NEAR(rows[0].coverage, 0.95, 0.044); // 4 deviations
    EXPECT_NEAR(rows[1].coverage, 0.95, 0.044);
}

TEST(Precision, FindsTheTrialsForAWidth) {
    std::vector<Precision> rows(3);
    rows[0] = {50, 0.0, 0.8, 0.0, 0.0, 0.0};
    rows[1] = {200, 0.0, 0.4, 0.0, 0.0, 0.0};
    rows[2] = {800, 0.0, 0.2, 0.0, 0.0, 0.0};
    EXPECT_EQ(trials_for_width(rows, 0.9), 50.0);
    EXPECT_NEAR(trials_for_width(rows, 0.6).value(), 100.0, 1e-9); // halfway in ln trials
    EXPECT_NEAR(trials_for_width(rows, 0.2).value(), 800.0, 1e-9);
    EXPECT_FALSE(trials_for_width(rows, 0.19).has_value());
}

TEST(Precision, GivesEachMethodItsTrials) {
    EXPECT_EQ(max_trials(with_trials(ConstantStimuli{{1.0, 2.0, 3.0}, 2, 1}, 13)), 18);
    Staircases staircases;
    staircases.start_levels = {1.0, 0.0};
    staircases.steps = {{0, 0.1}};
    EXPECT_EQ(max_trials(with_trials(staircases, 31)), 32);
    EXPECT_EQ(std::get<Staircases>(with_trials(staircases, 31)).reversals, 0);
    QuestPlus quest;
    quest.threshold_deviation = 1.0;
    EXPECT_EQ(max_trials(with_trials(quest, 31)), 31);
    EXPECT_EQ(std::get<QuestPlus>(with_trials(quest, 31)).threshold_deviation, 0.0);
    EXPECT_EQ(max_trials(with_trials(Adjustment{}, 31)), 31);
}

TEST(Precision, SaysWhatIsWrongWithTheQuestion) {
    PrecisionQuestion question = question_of_constant_stimuli();
    EXPECT_EQ(validate(question, Task{}), "");
    question.trials = {50, 50};
    EXPECT_EQ(validate(question, Task{}),
              "trials has 50 after 50; each must be above the one before");
    question.trials = {1};
    EXPECT_EQ(validate(question, Task{}), "trials (each) is 1; it must be from 2 to 10000");
    question = question_of_constant_stimuli();
    question.analysis.slope.minimum = 0.0;
    EXPECT_EQ(validate(question, Task{}), "slope.minimum is 0; it must be a finite number above 0");
}

} // namespace
} // namespace springdrive::study

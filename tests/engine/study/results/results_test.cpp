// Covers engine/study/results: counts, fits, traces, groups, tables and where participants stand.
#include "engine/study/results/study_results.h"

#include "engine/study/analysis/precision_plan.h"
#include "engine/study/conduct/conduct.h"
#include "tests/engine/study/conduct/small_study.h"
#include "tests/support/csv.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <sstream>

namespace springdrive::study {
namespace {

using Answer = std::function<bool(const PlannedTrial &)>;

/// The participant's whole sequence on one device, each trial right or wrong as `answer` says; one
/// in ten is marked and presented again.
void run_through(const Protocol &protocol, StudyContents &contents, const std::string &code,
                 DeviceKind device, const Answer &answer) {
    Participant participant{code, next_participant_number(contents), test_time(0)};
    Session session;
    session.id = static_cast<SessionId>(contents.sessions.size()) + 1;
    session.participant = code;
    session.device = device;
    session.ending = SessionEnding::completed;
    Sequence sequence(protocol, participant.number);
    contents.participants.push_back(participant);
    contents.sessions.push_back(session);
    while (const std::optional<PlannedTrial> planned = sequence.next()) {
        Trial trial(*planned);
        trial.participant = code;
        trial.session = session.id;
        const int right = *planned->target;
        trial.response = Chosen{answer(*planned) ? right : 3 - right};
        trial.is_correct = is_correct(protocol.task, trial);
        if (uniform(child(RandomKey{planned->seed}, 77)) < 0.1) {
            trial.marks = {"late"};
            trial.is_presented_again = true;
        }
        contents.trials.push_back(trial);
        sequence.add(trial);
    }
}

/// Right with the probability of the function.
Answer observer(const PsychometricFunction &function) {
    return [function](const PlannedTrial &planned) {
        return answer_of(function, *planned.level, RandomKey{planned.seed}).positive;
    };
}

constexpr PsychometricFunction kObserver{
    {Shape::cumulative_normal, Scale::linear}, 0.3, 8.0, 0.5, 0.0};

/// One block, one condition, constant stimuli.
Protocol constant_protocol() {
    Protocol protocol = small_protocol();
    protocol.conditions.resize(1);
    protocol.blocks = {{"only", {0}}};
    protocol.method = ConstantStimuli{{0.1, 0.2, 0.3, 0.4, 0.5}, 4, 2};
    protocol.practice = {};
    protocol.catch_trials = {};
    protocol.expected = Expectation{0.3, 8.0, 0.0, kObserver.family, "a test"};
    return protocol;
}

TEST(StudyResults, TellOfQuestionsThatWereBrokenOff) {
    Protocol protocol = constant_protocol();
    StudyContents contents;
    run_through(protocol, contents, "P01", DeviceKind::usb, observer(kObserver));
    const auto has_open = [&] {
        return progress_of(protocol, contents).front().has_open_questions;
    };
    std::optional<SessionEnding> &ending = contents.sessions.front().ending;
    ending = SessionEnding::stopped;
    EXPECT_FALSE(has_open()) << "there are none";
    protocol.questionnaire = {{"hand", QuestionnaireTime::before, "Which hand?"}};
    EXPECT_FALSE(has_open()) << "there are none after the last trial";
    protocol.questionnaire.push_back({"more", QuestionnaireTime::after, "Anything else?"});
    for (const std::optional<SessionEnding> broken_off :
         {std::optional(SessionEnding::stopped), std::optional(SessionEnding::left),
          std::optional(SessionEnding::interrupted), std::optional<SessionEnding>()}) {
        ending = broken_off;
        EXPECT_TRUE(has_open());
    }
    ending = SessionEnding::completed;
    EXPECT_FALSE(has_open()) << "who would rather not say has been asked";
    ending = SessionEnding::stopped;
    contents.answers = {{"P02", 1, "more", "Anything else?", "no", test_time(0)}};
    EXPECT_TRUE(has_open()) << "that is another one's answer";
    contents.answers.push_back({"P01", 1, "more", "Anything else?", "no", test_time(0)});
    EXPECT_FALSE(has_open());
    contents.answers.clear();
    contents.trials.pop_back();
    EXPECT_FALSE(has_open()) << "there are trials before them";
}

TEST(StudyResults, CountWhatCountsOnOneKindOfDevice) {
    const Protocol protocol = small_protocol();
    StudyContents contents;
    run_through(protocol, contents, "P01", DeviceKind::simulated, observer(kObserver));
    run_through(protocol, contents, "P02", DeviceKind::usb, observer(kObserver));
    for (const DeviceKind device : {DeviceKind::simulated, DeviceKind::usb}) {
        const StudyResults results = results_of(protocol, contents, device, [](double) {});
        ASSERT_EQ(results.series.size(), 4U) << "one participant, four conditions";
        for (const SeriesResult &result : results.series) {
            std::map<double, std::pair<int, int>> expected; // positive and all, by level
            int marked = 0;
            for (const Trial &trial : contents.trials) {
                const bool is_ours =
                    trial.participant == (device == DeviceKind::usb ? "P02" : "P01") &&
                    trial.condition == protocol.conditions[result.series.condition].name &&
                    !trial.is_practice && !trial.is_catch;
                marked += is_ours && !trial.marks.empty() ? 1 : 0;
                if (is_ours && trial.marks.empty()) {
                    expected[*trial.level].first += *trial.is_correct ? 1 : 0;
                    expected[*trial.level].second += 1;
                }
            }
            EXPECT_EQ(result.marked, marked);
            ASSERT_EQ(result.counts.size(), expected.size());
            for (const LevelCount &count : result.counts) {
                EXPECT_EQ(count.positive, expected[count.level].first);
                EXPECT_EQ(count.trials, expected[count.level].second);
            }
        }
    }
    EXPECT_TRUE(results_of(protocol, contents, DeviceKind::emulated, [](double) {}).series.empty());
}

/// Everything by brute force: the function's course and its interval from all nodes of a grid,
/// sorted by what they give.
TEST(StudyResults, DrawTheIntervalThatBruteForceFinds) {
    const Protocol protocol = constant_protocol();
    StudyContents contents;
    run_through(protocol, contents, "P01", DeviceKind::usb, observer(kObserver));
    const SeriesResult result =
        results_of(protocol, contents, DeviceKind::usb, [](double) {}).series.front();
    ASSERT_TRUE(result.fitted.has_value());
    const PsychometricFunction &shown = result.fitted->function;
    constexpr double kSpan = 0.4; // of the levels, from which usual_priors takes all ranges
    for (const std::size_t at : {20U, 45U, 65U}) {
        const FunctionPoint &point = result.fitted->course[at];
        std::vector<std::pair<double, double>> weighted; // F, its weight
        double all = 0.0;
        constexpr int kNodes = 160;
        for (int t = 0; t < kNodes; ++t) {
            for (int s = 0; s < kNodes; ++s) {
                for (int l = 0; l < 10; ++l) {
                    const double threshold = -0.1 + 2.0 * kSpan * (t + 0.5) / kNodes;
                    const double slope = 0.5 / kSpan * std::pow(100.0, (s + 0.5) / kNodes);
                    const double lapse = 0.1 * (l + 0.5) / 10.0;
                    double likelihood = 1.0;
                    const auto core = [&](double level) {
                        return 0.5 * std::erfc(-slope * (level - threshold) / std::sqrt(2.0));
                    };
                    for (const LevelCount &count : result.counts) {
                        const double p = 0.5 + (0.5 - lapse) * core(count.level);
                        likelihood *= std::pow(p, count.positive) *
                                      std::pow(1.0 - p, count.trials - count.positive);
                    }
                    weighted.emplace_back(core(point.level), likelihood);
                    all += likelihood;
                }
            }
        }
        std::ranges::sort(weighted);
        const auto quantile = [&](double share) {
            double sum = 0.0;
            for (const auto &[core, weight] : weighted) {
                sum += weight;
                if (sum >= share * all) {
                    return core;
                }
            }
            return 1.0;
        };
        const auto proportion = [&shown](double core) { return 0.5 + (0.5 - shown.lapse) * core; };
        // F changes by up to 0.02 from node to node of this grid; the course interpolates between
        // 50 values of F.
        EXPECT_NEAR(point.low, proportion(quantile(0.025)), 0.012) << point.level;
        EXPECT_NEAR(point.high, proportion(quantile(0.975)), 0.012) << point.level;
        EXPECT_LT(point.low, point.proportion);
        EXPECT_GT(point.high, point.proportion);
    }
}

TEST(StudyResults, GiveWebersFractionOfWhatIsFelt) {
    Protocol protocol = small_protocol(); // η added to 0.2
    EXPECT_NEAR(*weber_fraction_of(protocol, 0.2), (0.8 - 0.6) / 0.8, 1e-12) << "of the stiffness";
    protocol.variable = {"dR_Ohm", LevelMeaning::taken_off, 1.2, "", false};
    EXPECT_NEAR(*weber_fraction_of(protocol, 0.3), 0.3 / 1.2, 1e-12);
    protocol.variable.standard_condition = "hard";
    EXPECT_FALSE(weber_fraction_of(protocol, 0.3).has_value());
    protocol.variable = {"turn_deg", LevelMeaning::value, 0.0, "", false};
    EXPECT_FALSE(weber_fraction_of(protocol, 25.0).has_value()) << "nothing to compare with";
    protocol.variable = {"dR_Ohm", LevelMeaning::taken_off, 1.2, "", false};
    protocol.task.kind = TaskKind::yes_no;
    EXPECT_FALSE(weber_fraction_of(protocol, 0.3).has_value());
}

/// Two right answers lower the level, a wrong one raises it.
TEST(StudyResults, TraceTheReversalsOfAStaircase) {
    Protocol protocol = constant_protocol();
    Staircases staircases;
    staircases.start_levels = {0.5};
    staircases.maximum_level = 0.7;
    staircases.steps = {{0, 0.1}};
    staircases.reversals = 0;
    staircases.trials = 8;
    protocol.method = staircases;
    const std::vector<bool> answers{true, true, false, true, true, true, true, false};
    const std::vector<double> levels{0.5, 0.5, 0.4, 0.5, 0.5, 0.4, 0.4, 0.3};
    const std::vector<bool> reversals{false, false, true, false, true, false, false, true};
    Series series;
    series.runs.emplace_back();
    StaircasesRun run(staircases, RandomKey{});
    for (std::size_t i = 0; i < answers.size(); ++i) {
        EXPECT_NEAR(run.next()->level, levels[i], 1e-12) << i;
        Trial &trial = series.runs.front().trials.emplace_back();
        trial.level = run.next()->level; // to the last bit
        trial.target = 1;
        trial.response = Chosen{answers[i] ? 1 : 2};
        run.add(method_trial(protocol, trial));
    }
    const std::vector<TracePoint> trace = trace_of(protocol, series);
    ASSERT_EQ(trace.size(), answers.size());
    for (std::size_t i = 0; i < trace.size(); ++i) {
        EXPECT_EQ(trace[i].trial, static_cast<int>(i) + 1);
        EXPECT_EQ(trace[i].outcome.positive, answers[i]) << i;
        EXPECT_EQ(trace[i].is_reversal, reversals[i]) << i;
    }
    const std::vector<TrackEstimate> estimates = reversals_of(protocol, series);
    ASSERT_EQ(estimates.size(), 1U);
    EXPECT_EQ(estimates.front().estimate.reversals, 2) << "of three, the first left out";
    EXPECT_NEAR(estimates.front().estimate.level, 0.5 * (0.5 + 0.3), 1e-12);

    series.runs.front().trials.erase(series.runs.front().trials.begin() + 3);
    EXPECT_EQ(trace_of(protocol, series).size(), 7U) << "a gap: levels only";
    EXPECT_TRUE(reversals_of(protocol, series).empty());
}

TEST(StudyResults, SummariseAGroup) {
    const Protocol protocol = constant_protocol();
    StudyContents contents;
    run_through(protocol, contents, "P01", DeviceKind::usb, observer(kObserver));
    const StudyResults one = results_of(protocol, contents, DeviceKind::usb, [](double) {});
    ASSERT_EQ(one.conditions.size(), 1U);
    EXPECT_NEAR(one.conditions[0].mean, one.series[0].fitted->threshold.mean, 1e-9);
    EXPECT_TRUE(std::isinf(one.conditions[0].high)) << "one participant tells nothing of others";

    PsychometricFunction dull = kObserver; // who needs twice as much, and is sure then
    dull.threshold = 0.6;
    dull.slope = 40.0;
    run_through(protocol, contents, "P02", DeviceKind::usb, observer(dull));
    const StudyResults two = results_of(protocol, contents, DeviceKind::usb, [](double) {});
    EXPECT_EQ(two.conditions[0].on_scale.participants, 2);
    EXPECT_GT(two.conditions[0].mean, two.series[0].fitted->threshold.mean);
    EXPECT_LT(two.conditions[0].mean, two.series[1].fitted->threshold.mean);
}

TEST(StudyResults, FillEveryColumnOfTheirTables) {
    Protocol protocol = constant_protocol();
    protocol.conditions.front().name = "soft, \"very\"";
    StudyContents contents;
    run_through(protocol, contents, "P01", DeviceKind::usb, observer(kObserver));
    const StudyResults results = results_of(protocol, contents, DeviceKind::usb, [](double) {});
    for (const ResultsTable &table : kResultsTables) {
        std::ostringstream out;
        write_csv(out, table.make(protocol, results));
        const auto lines = testing::parsed_csv(out.str());
        ASSERT_GT(lines.size(), 1U) << table.file;
        for (const auto &line : lines) {
            EXPECT_EQ(line.size(), lines.front().size()) << table.file;
        }
    }
}

TEST(StudyProgress, TellsWhereEachParticipantStands) {
    const Protocol protocol = small_protocol();
    StudyContents contents;
    run_through(protocol, contents, "P01", DeviceKind::usb, observer(kObserver));
    run_through(protocol, contents, "P02", DeviceKind::simulated, observer(kObserver));
    contents.trials.pop_back(); // of P02
    const PlannedTrial last = *sequence_after(protocol, 2, trials_of(contents, "P02")).next();
    contents.participants.push_back({"P03", 3, test_time(0)});
    const std::vector<Progress> progress = progress_of(protocol, contents);
    ASSERT_EQ(progress.size(), 3U);
    EXPECT_FALSE(progress[0].next.has_value());
    EXPECT_EQ(progress[0].devices, std::vector{DeviceKind::usb});
    EXPECT_EQ(progress[1].next, last);
    EXPECT_EQ(progress[1].trials, std::ssize(trials_of(contents, "P02")));
    EXPECT_EQ(progress[2].sessions, 0);
    EXPECT_EQ(progress[2].next, Sequence(protocol, 3).next());
    contents.trials.front().level = 0.123;
    EXPECT_THROW(static_cast<void>(progress_of(protocol, contents)), InputError);
}

} // namespace
} // namespace springdrive::study

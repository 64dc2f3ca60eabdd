#include "engine/study/protocol/session_plan.h"

#include "base/assertions.h"
#include "engine/study/protocol/study_setting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <variant>

namespace springdrive::study {

namespace {

double trial_s(const Protocol &protocol, double approach_s) {
    const TrialTiming &timing = protocol.timing;
    const int presentations = presentations_per_trial(protocol);
    return timing.rest_s +
           presentations * (approach_s + timing.presentation_s + longest_glide_back_s(protocol)) +
           (presentations - 1) * timing.pause_s + timing.expected_response_s +
           timing.between_trials_s;
}

/// A track of staircases ends at the earliest where it turns after every step: of its reversals
/// plus one runs every second is a step down, of n right answers.
int min_in_track(const Staircases &method) {
    if (method.reversals == 0) {
        return method.trials;
    }
    const int runs = method.reversals + 1;
    return std::min(method.trials, (runs + 1) / 2 + runs / 2 * method.correct_for_down);
}

/// With the catch trials among them: of each `one_in` one.
int with_catch_trials(int trials, const CatchTrials &catch_trials) {
    return catch_trials.one_in < 2 ? trials : trials + trials / (catch_trials.one_in - 1);
}

int breaks_within(int trials, const Breaks &breaks) {
    return breaks.every_trials < 1 || trials < 1 ? 0 : (trials - 1) / breaks.every_trials;
}

Scale scale_of(const Protocol &protocol) {
    if (const auto *staircases = std::get_if<Staircases>(&protocol.method)) {
        return staircases->scale;
    }
    if (const auto *adjustment = std::get_if<Adjustment>(&protocol.method)) {
        return adjustment->scale;
    }
    const bool are_ratios =
        is_forced_choice(protocol.task.kind) &&
        std::ranges::all_of(presentable_levels(protocol), [](double level) { return level > 0.0; });
    return are_ratios ? Scale::logarithmic : Scale::linear;
}

} // namespace

bool restarts_within_trial(const Protocol &protocol) {
    const std::optional<std::size_t> shared = standard_condition_of(protocol);
    if (!shared || presentations_per_trial(protocol) < 2) {
        return false;
    }
    const Condition &standard = protocol.conditions[*shared];
    return std::ranges::any_of(protocol.conditions, [&standard](const Condition &one) {
        return one.servo_hz != standard.servo_hz || one.delay_periods != standard.delay_periods ||
               one.scene != standard.scene;
    });
}

double usual_trial_s(const Protocol &protocol) {
    return trial_s(protocol, 0.5 * protocol.timing.approach_s);
}

double long_trial_s(const Protocol &protocol) {
    return trial_s(protocol, protocol.timing.approach_s);
}

int min_trials(const Method &method) {
    return std::visit(
        [](const auto &one) {
            using Kind = std::decay_t<decltype(one)>;
            if constexpr (std::is_same_v<Kind, ConstantStimuli>) {
                return max_trials(one);
            } else if constexpr (std::is_same_v<Kind, Staircases>) {
                return static_cast<int>(one.start_levels.size()) * min_in_track(one);
            } else if constexpr (std::is_same_v<Kind, QuestPlus>) {
                return one.threshold_deviation > 0.0 ? one.min_trials : one.max_trials;
            } else {
                return one.settings;
            }
        },
        method);
}

SessionLength session_length(const Protocol &protocol, double warm_up_s) {
    SessionLength session;
    session.warm_up_s = warm_up_s;
    const double usual_s = usual_trial_s(protocol);
    const double long_s = long_trial_s(protocol);
    for (std::size_t i = 0; i < protocol.blocks.size(); ++i) {
        const auto series = static_cast<int>(protocol.blocks[i].conditions.size());
        BlockLength block;
        block.min_trials =
            (i == 0 && protocol.practice.max_trials > 0 ? protocol.practice.min_trials : 0) +
            with_catch_trials(series * min_trials(protocol.method), protocol.catch_trials);
        block.max_trials = max_trials(block_of(protocol, i, i == 0));
        block.min_s = block.min_trials * usual_s +
                      breaks_within(block.min_trials, protocol.breaks) * protocol.breaks.break_s;
        block.max_s = block.max_trials * long_s +
                      breaks_within(block.max_trials, protocol.breaks) * protocol.breaks.break_s;
        const int in_a_row = protocol.breaks.every_trials < 1
                                 ? block.max_trials
                                 : std::min(block.max_trials, protocol.breaks.every_trials);
        session.longest_without_break_s =
            std::max(session.longest_without_break_s, in_a_row * long_s);
        session.min_trials += block.min_trials;
        session.max_trials += block.max_trials;
        session.min_s += block.min_s;
        session.max_s += block.max_s;
        session.blocks.push_back(block);
    }
    const double between_s =
        protocol.breaks.between_blocks_s *
        static_cast<double>(std::max<std::size_t>(session.blocks.size(), 1) - 1);
    for (const QuestionnaireItem &item : protocol.questionnaire) {
        session.min_questions_s += kShortQuestion_s;
        session.max_questions_s +=
            item.kind == QuestionnaireKind::text ? kLongText_s : kLongChoice_s;
    }
    session.min_s += warm_up_s + between_s + session.min_questions_s;
    session.max_s += warm_up_s + between_s + session.max_questions_s;
    return session;
}

FunctionFamily analysis_family(const Protocol &protocol) {
    if (const auto *quest = std::get_if<QuestPlus>(&protocol.method)) {
        return quest->family;
    }
    if (protocol.expected) {
        return protocol.expected->family;
    }
    const Scale scale = scale_of(protocol);
    return {scale == Scale::linear ? Shape::cumulative_normal : Shape::weibull, scale};
}

FunctionPriors analysis_priors(const Protocol &protocol) {
    if (const auto *quest = std::get_if<QuestPlus>(&protocol.method)) {
        return priors_of(*quest);
    }
    return usual_priors(analysis_family(protocol), protocol.task, presentable_levels(protocol));
}

PsychometricFunction expected_observer(const Protocol &protocol) {
    SPRINGDRIVE_ASSERT(protocol.expected.has_value());
    const Expectation &expected = *protocol.expected;
    return {expected.family, expected.threshold, expected.slope, guess_range(protocol.task).minimum,
            expected.lapse};
}

int usual_trials(const Protocol &protocol, const PsychometricFunction &observer) {
    if (min_trials(protocol.method) == max_trials(protocol.method)) {
        return max_trials(protocol.method);
    }
    const RandomKey key = key_of(static_cast<std::uint64_t>(protocol.seed), 0);
    std::array<std::size_t, 21> trials{};
    for (std::size_t i = 0; i < trials.size(); ++i) {
        trials[i] = simulated_trials(protocol.method, observer, child(key, i)).size();
    }
    std::ranges::sort(trials);
    return static_cast<int>(trials[trials.size() / 2]);
}

PrecisionQuestion precision_question(const Protocol &protocol,
                                     const PsychometricFunction &observer) {
    PrecisionQuestion question;
    question.method = protocol.method;
    question.seed = static_cast<std::uint64_t>(protocol.seed);
    question.observers = {observer.family, known(observer.threshold), known(observer.slope),
                          known(observer.guess), known(observer.lapse)};
    question.analysis = analysis_priors(protocol);
    return question;
}

} // namespace springdrive::study

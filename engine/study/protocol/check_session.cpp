#include "engine/study/protocol/checks.h"

#include "engine/study/protocol/analysis_plan.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace springdrive::study {

namespace {

constexpr double kLongWithoutBreak_s = 900.0;

void check_length(ProtocolFindings &findings, const Protocol &protocol,
                  const SessionLength &length) {
    const double longest_s = 60.0 * protocol.stopping.longest_session_min;
    if (length.min_s > longest_s) {
        findings.push_back(
            {Severity::error, "session",
             fmt::format("takes {:.0f} min at the least, with {} trials and all breaks; it ends "
                         "after {:g} min",
                         length.min_s / 60.0, length.min_trials,
                         protocol.stopping.longest_session_min),
             "ask for fewer trials, shorten timing or breaks, or raise "
             "stopping.longest_session_min"});
    } else if (length.max_s > longest_s) {
        findings.push_back(
            {Severity::warning, "session",
             fmt::format("may take up to {:.0f} min, with {} trials; it ends after {:g} min",
                         length.max_s / 60.0, length.max_trials,
                         protocol.stopping.longest_session_min),
             "lower the most trials of the method, or raise stopping.longest_session_min"});
    }
    if (length.longest_without_break_s > kLongWithoutBreak_s) {
        findings.push_back({Severity::warning, "breaks",
                            fmt::format("leave the hand up to {:.0f} min without a rest",
                                        length.longest_without_break_s / 60.0),
                            fmt::format("lower breaks.every_trials; {:g} min are long",
                                        kLongWithoutBreak_s / 60.0)});
    }
}

void check_order(ProtocolFindings &findings, const Protocol &protocol) {
    const auto blocks = static_cast<int>(protocol.blocks.size());
    if (blocks < 2) {
        return;
    }
    const std::string_view kind =
        kCounterbalancingNames[static_cast<std::size_t>(protocol.counterbalancing)];
    const int balanced = participants_to_balance(protocol.counterbalancing, blocks);
    if (balanced == 1) {
        findings.push_back({Severity::warning, "counterbalancing",
                            fmt::format("is {}: blocks that come late may differ by practice or "
                                        "fatigue alone",
                                        kind),
                            "choose balanced_latin_square or full"});
    } else if (const int over = protocol.participants % balanced; over != 0) {
        findings.push_back(
            {Severity::warning, "participants",
             fmt::format("are {}; orders of {} blocks by {} are balanced with a multiple of {}",
                         protocol.participants, blocks, kind, balanced),
             fmt::format("plan for {}", protocol.participants + balanced - over)});
    }
}

void check_expectation(ProtocolFindings &findings, const Protocol &protocol) {
    if (!protocol.expected) {
        return;
    }
    const std::vector<double> levels = presentable_levels(protocol);
    const double threshold = protocol.expected->threshold;
    if (threshold < levels.front() || threshold > levels.back()) {
        findings.push_back({Severity::warning, "method",
                            fmt::format("presents levels from {:g} to {:g}; the threshold that is "
                                        "expected, {:g}, lies outside",
                                        levels.front(), levels.back(), threshold),
                            "move the levels about it"});
    }
}

/// A restart of the servo takes the pause between two intervals.
void check_pause(ProtocolFindings &findings, const Protocol &protocol) {
    if (restarts_within_trial(protocol) && protocol.timing.pause_s < kRestart_s) {
        findings.push_back(
            {Severity::error, "timing",
             fmt::format("has a pause of {:g} s; between intervals of different servo rate, delay "
                         "or scene the servo starts anew, in {:g} s",
                         protocol.timing.pause_s, kRestart_s),
             fmt::format("raise timing.pause_s to {:g} or more", kRestart_s)});
    }
}

} // namespace

ProtocolFindings check_session(const Protocol &protocol, const SessionLength &length) {
    ProtocolFindings findings;
    check_length(findings, protocol, length);
    check_order(findings, protocol);
    check_expectation(findings, protocol);
    check_pause(findings, protocol);
    return findings;
}

ProtocolFindings check_precision(const Protocol &protocol) {
    if (!protocol.expected) {
        return {
            {Severity::note, "precision", "to be expected is not known without [expected]", ""}};
    }
    const PsychometricFunction observer = expected_observer(protocol);
    PrecisionQuestion question = precision_question(protocol, observer);
    question.studies = 60; // a median width to within some 5 %
    question.trials = {usual_trials(protocol, observer)};
    if (const std::string wrong = validate(question, protocol.task); !wrong.empty()) {
        return {{Severity::warning, "precision", "cannot be reckoned: " + wrong,
                 "give [expected] a function that fits the method"}};
    }
    const Precision precision = precision_by_trials(question).front();
    const bool ratios = question.analysis.family.scale == Scale::logarithmic;
    const double width = ratios ? std::exp(precision.median_width) : precision.median_width;
    return {{Severity::note, "precision",
             fmt::format("a participant's threshold in a condition is known to within {} {:.3g} "
                         "(95 % interval, from end to end, in the median), with {} trials and "
                         "observers as expected",
                         ratios ? "a factor of" : "a width of", width, precision.trials),
             ""}};
}

} // namespace springdrive::study

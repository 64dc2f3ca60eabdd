#include "engine/study/results/trace.h"

#include "engine/study/methods/method.h"

#include <cstddef>
#include <span>
#include <variant>

namespace springdrive::study {

namespace {

std::vector<PastMethodTrial> as_seen_by_method(const Protocol &protocol, const MethodTrials &run) {
    std::vector<PastMethodTrial> trials;
    for (const Trial &trial : run.trials) {
        trials.push_back(method_trial(protocol, trial));
    }
    return trials;
}

/// Whether these are the first trials of the method, without a gap: where the method decides by
/// the answers, it can be run through them again.
bool is_without_gap(const Method &method, std::span<const PastMethodTrial> trials) {
    if (const auto *staircases = std::get_if<Staircases>(&method)) {
        StaircasesRun run(*staircases, RandomKey{});
        for (const PastMethodTrial &trial : trials) {
            const auto track = static_cast<std::size_t>(trial.presented.track);
            if (track >= run.tracks().size() ||
                run.tracks()[track].level != trial.presented.level) {
                return false;
            }
            run.add(trial);
        }
        return true;
    }
    QuestPlusRun run(std::get<QuestPlus>(method));
    for (const PastMethodTrial &trial : trials) {
        const std::optional<MethodTrial> next = run.next();
        if (!next || next->level != trial.presented.level) {
            return false;
        }
        run.add(trial);
    }
    return true;
}

void add_reversals(const Staircases &method, std::span<const PastMethodTrial> trials,
                   std::span<TracePoint> points) {
    StaircasesRun run(method, RandomKey{}); // the key draws tracks, which are known by now
    for (std::size_t i = 0; i < trials.size(); ++i) {
        const auto track = static_cast<std::size_t>(trials[i].presented.track);
        const std::size_t before = run.tracks()[track].reversal_levels.size();
        run.add(trials[i]);
        points[i].is_reversal = run.tracks()[track].reversal_levels.size() > before;
    }
}

void add_estimates(const QuestPlus &method, std::span<const PastMethodTrial> trials,
                   std::span<TracePoint> points) {
    const Scale scale = method.threshold.prior.scale;
    QuestPlusRun run(method);
    for (std::size_t i = 0; i < trials.size(); ++i) {
        run.add(trials[i]);
        const double u = on_scale(scale, run.mean().threshold);
        points[i].threshold = run.mean().threshold;
        points[i].threshold_low = level_from(scale, u - run.threshold_deviation());
        points[i].threshold_high = level_from(scale, u + run.threshold_deviation());
    }
}

} // namespace

std::vector<TracePoint> trace_of(const Protocol &protocol, const Series &series) {
    std::vector<TracePoint> points;
    for (const MethodTrials &run : series.runs) {
        const std::vector<PastMethodTrial> trials = as_seen_by_method(protocol, run);
        const std::size_t first = points.size();
        for (const PastMethodTrial &trial : trials) {
            TracePoint point;
            point.block = run.block;
            point.trial = static_cast<int>(points.size() - first) + 1;
            point.track = trial.presented.track;
            point.level = trial.presented.level;
            point.outcome = trial.outcome;
            points.push_back(point);
        }
        const auto *staircases = std::get_if<Staircases>(&protocol.method);
        const auto *quest = std::get_if<QuestPlus>(&protocol.method);
        if ((staircases == nullptr && quest == nullptr) ||
            !is_without_gap(protocol.method, trials)) {
            continue;
        }
        const std::span<TracePoint> of_run = std::span(points).subspan(first);
        if (staircases != nullptr) {
            add_reversals(*staircases, trials, of_run);
        } else {
            add_estimates(*quest, trials, of_run);
        }
    }
    return points;
}

std::vector<TrackEstimate> reversals_of(const Protocol &protocol, const Series &series) {
    const auto *method = std::get_if<Staircases>(&protocol.method);
    std::vector<TrackEstimate> all;
    if (method == nullptr) {
        return all;
    }
    for (const MethodTrials &run : series.runs) {
        const std::vector<PastMethodTrial> trials = as_seen_by_method(protocol, run);
        if (!is_without_gap(*method, trials)) {
            continue;
        }
        const std::vector<std::optional<ReversalEstimate>> estimates =
            reversal_estimates(*method, trials, method->steps.back().from_reversal);
        for (std::size_t track = 0; track < estimates.size(); ++track) {
            if (estimates[track]) {
                all.push_back({run.block, static_cast<int>(track), *estimates[track]});
            }
        }
    }
    return all;
}

} // namespace springdrive::study

#include "engine/study/methods/staircases.h"

#include "base/assertions.h"
#include "engine/study/methods/turns.h"
#include "engine/study/methods/wrong_value.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace springdrive::study {

namespace {

std::string validate_steps(const Staircases &method) {
    if (method.steps.empty()) {
        return "steps is empty; it must have at least one";
    }
    const bool ratios = method.scale == Scale::logarithmic;
    for (std::size_t i = 0; i < method.steps.size(); ++i) {
        const StepSize &step = method.steps[i];
        const std::string key = fmt::format("steps[{}]", i);
        const double fewest = i == 0 ? 0.0 : method.steps[i - 1].from_reversal + 1.0;
        if (std::string error =
                first_of({unless_from_to(key + ".from_reversal", step.from_reversal, fewest,
                                         i == 0 ? 0.0 : 1000.0),
                          unless_above(key + ".size", step.size, ratios ? 1.0 : 0.0)});
            !error.empty()) {
            return error;
        }
    }
    return {};
}

} // namespace

std::string validate(const Staircases &method) {
    if (std::string error =
            first_of({unless_level("minimum_level", method.minimum_level, method.scale),
                      unless_above("maximum_level", method.maximum_level, method.minimum_level),
                      out_of_range(kStaircaseFields, method), validate_steps(method),
                      unless_from_to("start_levels (how many)",
                                     static_cast<double>(method.start_levels.size()), 1, 16)});
        !error.empty()) {
        return error;
    }
    for (const double level : method.start_levels) {
        if (std::string error = unless_from_to("start_levels (each)", level, method.minimum_level,
                                               method.maximum_level);
            !error.empty()) {
            return error;
        }
    }
    return {};
}

double convergence_proportion(const Staircases &method) {
    return std::pow(method.up_to_down / (1.0 + method.up_to_down), 1.0 / method.correct_for_down);
}

StaircasesRun::StaircasesRun(const Staircases &method, RandomKey key) : method_(method), key_(key) {
    for (const double level : method.start_levels) {
        tracks_.emplace_back().level = level;
    }
}

bool StaircasesRun::is_done(const StaircaseTrack &track) const {
    return track.trials >= method_.trials ||
           (method_.reversals > 0 && std::ssize(track.reversal_levels) >= method_.reversals);
}

bool StaircasesRun::is_done() const {
    return std::ranges::all_of(tracks_, [this](const StaircaseTrack &t) { return is_done(t); });
}

std::optional<MethodTrial> StaircasesRun::next() const {
    std::vector<Interleaved> all;
    for (const StaircaseTrack &track : tracks_) {
        all.push_back({track.trials, is_done(track)});
    }
    const std::optional<std::size_t> turn = next_turn(all, child(key_, trials_));
    return turn ? std::optional(MethodTrial{tracks_[*turn].level, static_cast<int>(*turn)})
                : std::nullopt;
}

void StaircasesRun::add(const PastMethodTrial &trial) {
    ++trials_;
    if (trial.outcome.marked) {
        return;
    }
    const auto number = static_cast<std::size_t>(trial.presented.track);
    SPRINGDRIVE_ASSERT(number < tracks_.size());
    StaircaseTrack &track = tracks_[number];
    ++track.trials;
    track.correct_in_a_row = trial.outcome.positive ? track.correct_in_a_row + 1 : 0;
    if (trial.outcome.positive && track.correct_in_a_row < method_.correct_for_down) {
        return;
    }
    const int direction = trial.outcome.positive ? -1 : 1;
    if (direction == -track.last_step) {
        track.reversal_levels.push_back(trial.presented.level);
        track.reversal_directions.push_back(direction);
    }
    track.correct_in_a_row = 0;
    track.last_step = direction;
    track.level =
        stepped(trial.presented.level, direction, static_cast<int>(track.reversal_levels.size()));
}

double StaircasesRun::stepped(double level, int direction, int reversals) const {
    const auto beyond =
        std::ranges::upper_bound(method_.steps, reversals, {}, &StepSize::from_reversal);
    const double size = on_scale(method_.scale, std::prev(beyond)->size);
    const double step = direction > 0 ? method_.up_to_down * size : -size;
    return std::clamp(level_from(method_.scale, on_scale(method_.scale, level) + step),
                      method_.minimum_level, method_.maximum_level);
}

} // namespace springdrive::study

#include "engine/study/methods/method.h"

#include "base/assertions.h"

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

/// h(ψ) [nat].
double answer_entropy(double proportion) {
    return -proportion * std::log(proportion) - (1.0 - proportion) * std::log1p(-proportion);
}

using AnyRun = std::variant<ConstantStimuliRun, StaircasesRun, QuestPlusRun, AdjustmentRun>;

AnyRun started(const ConstantStimuli &method, RandomKey key) {
    return ConstantStimuliRun(method, key);
}
AnyRun started(const Staircases &method, RandomKey key) { return StaircasesRun(method, key); }
AnyRun started(const QuestPlus &method, RandomKey) { return QuestPlusRun(method); }
AnyRun started(const Adjustment &method, RandomKey key) { return AdjustmentRun(method, key); }

/// What a method that is well in itself asks of its task.
std::string validate_task(const Staircases &method, const Task &task) {
    const double target = convergence_proportion(method);
    const double chance = guess_range(task).minimum;
    return target > chance
               ? std::string()
               : fmt::format("correct_for_down is {} and up_to_down {:g}, which converges to {:g} "
                             "correct; it must be above {:g}, which is chance",
                             method.correct_for_down, method.up_to_down, target, chance);
}

std::string validate_task(const QuestPlus &method, const Task &task) {
    const GuessRange range = guess_range(task);
    const Prior &guess = method.guess.prior;
    return guess.minimum >= range.minimum && guess.maximum <= range.maximum
               ? std::string()
               : fmt::format(
                     "guess is from {:g} to {:g}; in this task it must be from {:g} to {:g}",
                     guess.minimum, guess.maximum, range.minimum, range.maximum);
}

std::string validate_task(const ConstantStimuli &, const Task &) { return {}; }
std::string validate_task(const Adjustment &, const Task &) { return {}; }

} // namespace

std::string validate(const Task &task) {
    return first_of({out_of_range(kTaskFields, task),
                     is_forced_choice(task.kind)
                         ? std::string()
                         : unless_from_to("alternatives", task.alternatives, 2.0, 2.0)});
}

GuessRange guess_range(const Task &task) {
    if (is_forced_choice(task.kind)) {
        return {1.0 / task.alternatives, 1.0 / task.alternatives};
    }
    return {0.0, task.kind == TaskKind::yes_no ? task.largest_false_alarm_rate : 0.0};
}

std::string validate(const ConstantStimuli &method) {
    return first_of(
        {unless_rising("levels", method.levels, 1), out_of_range(kConstantStimuliFields, method)});
}

int max_trials(const ConstantStimuli &method) {
    return static_cast<int>(method.levels.size()) * method.repetitions * method.blocks;
}

ConstantStimuliRun::ConstantStimuliRun(const ConstantStimuli &method, RandomKey key)
    : method_(method), key_(key) {
    start_block();
}

std::optional<MethodTrial> ConstantStimuliRun::next() const {
    return is_done() ? std::nullopt : std::optional(MethodTrial{left_.front(), 0});
}

void ConstantStimuliRun::add(const PastMethodTrial &trial) {
    left_.erase(left_.begin());
    if (trial.outcome.marked) {
        // Not the first place, so that a participant who felt half of it is not asked at once.
        const std::size_t others = left_.size();
        const std::size_t place =
            others == 0 ? 0 : 1 + below(child(child(key_, 1), trials_), others);
        left_.insert(left_.begin() + static_cast<std::ptrdiff_t>(place), trial.presented.level);
    }
    ++trials_;
    if (left_.empty() && blocks_started_ < method_.blocks) {
        start_block();
    }
}

void ConstantStimuliRun::start_block() {
    for (int i = 0; i < method_.repetitions; ++i) {
        left_.insert(left_.end(), method_.levels.begin(), method_.levels.end());
    }
    shuffle(child(child(key_, 0), static_cast<std::uint64_t>(blocks_started_)), std::span(left_));
    ++blocks_started_;
}

std::string validate(const Adjustment &method) {
    return first_of({unless_level("minimum_level", method.minimum_level, method.scale),
                     unless_above("maximum_level", method.maximum_level, method.minimum_level),
                     unless_from_to("minimum_start", method.minimum_start, method.minimum_level,
                                    method.maximum_level),
                     unless_from_to("maximum_start", method.maximum_start, method.minimum_start,
                                    method.maximum_level),
                     out_of_range(kAdjustmentFields, method)});
}

std::optional<MethodTrial> AdjustmentRun::next() const {
    if (is_done()) {
        return std::nullopt;
    }
    const double first = on_scale(method_.scale, method_.minimum_start);
    const double last = on_scale(method_.scale, method_.maximum_start);
    const double share = uniform(child(key_, static_cast<std::uint64_t>(settings_)));
    return MethodTrial{level_from(method_.scale, first + share * (last - first)), 0};
}

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

FunctionPriors priors_of(const QuestPlus &method) {
    return {method.family, method.threshold.prior, method.slope.prior, method.guess.prior,
            method.lapse.prior};
}

double table_cells(const QuestPlus &method) {
    return static_cast<double>(method.levels.size()) * method.threshold.points *
           method.slope.points * method.guess.points * method.lapse.points;
}

std::string validate(const QuestPlus &method) {
    constexpr double kMaxPoints = kPriorAxisFields.front().range.maximum;
    return first_of(
        {unless_rising("levels", method.levels, 2),
         method.levels.empty()
             ? std::string()
             : unless_level("levels (each)", method.levels.front(), method.family.scale),
         unless_level("threshold.minimum", method.threshold.prior.minimum, method.family.scale),
         unless_level("slope.minimum", method.slope.prior.minimum, Scale::logarithmic),
         validate(priors_of(method)),
         unless_from_to("threshold.points", method.threshold.points, 2, kMaxPoints),
         unless_from_to("slope.points", method.slope.points, 1, kMaxPoints),
         unless_from_to("guess.points", method.guess.points, 1, kMaxPoints),
         unless_from_to("lapse.points", method.lapse.points, 1, kMaxPoints),
         unless_from_to("levels times all points", table_cells(method), 1.0, kMaxQuestTable),
         out_of_range(kQuestPlusFields, method),
         unless_from_to("fewest_trials", method.min_trials, 1, method.max_trials)});
}

QuestPlusRun::QuestPlusRun(const QuestPlus &method) : method_(method) {
    const PriorGrid threshold = grid_of(method.threshold.prior, method.threshold.points);
    const PriorGrid slope = grid_of(method.slope.prior, method.slope.points);
    const PriorGrid guess = grid_of(method.guess.prior, method.guess.points);
    const PriorGrid lapse = grid_of(method.lapse.prior, method.lapse.points);
    std::vector<double> weights;
    for (std::size_t t = 0; t < threshold.values.size(); ++t) {
        for (std::size_t s = 0; s < slope.values.size(); ++s) {
            for (std::size_t g = 0; g < guess.values.size(); ++g) {
                for (std::size_t l = 0; l < lapse.values.size(); ++l) {
                    functions_.push_back({method.family, threshold.values[t], slope.values[s],
                                          guess.values[g], lapse.values[l]});
                    weights.push_back(threshold.weights[t] * slope.weights[s] * guess.weights[g] *
                                      lapse.weights[l]);
                }
            }
        }
    }
    const auto functions = static_cast<Eigen::Index>(functions_.size());
    posterior_ = Eigen::Map<const Eigen::VectorXd>(weights.data(), functions);
    proportions_.resize(std::ssize(method.levels), functions);
    for (Eigen::Index i = 0; i < proportions_.rows(); ++i) {
        for (Eigen::Index j = 0; j < functions; ++j) {
            proportions_(i, j) =
                possible_proportion(proportion_at(functions_[static_cast<std::size_t>(j)],
                                                  method.levels[static_cast<std::size_t>(i)]));
        }
    }
    answer_entropies_ = proportions_.unaryExpr(&answer_entropy);
}

bool QuestPlusRun::is_done() const {
    return trials_ >= method_.max_trials ||
           (method_.threshold_deviation > 0.0 && trials_ >= method_.min_trials &&
            threshold_deviation() <= method_.threshold_deviation);
}

std::optional<MethodTrial> QuestPlusRun::next() const {
    if (is_done()) {
        return std::nullopt;
    }
    Eigen::Index most = 0;
    information().maxCoeff(&most);
    return MethodTrial{method_.levels[static_cast<std::size_t>(most)], 0};
}

void QuestPlusRun::add(const PastMethodTrial &trial) {
    if (trial.outcome.marked) {
        return;
    }
    // As it was presented, not as it would be chosen now: rounding may break a tie another way on
    // another machine.
    const auto found = std::ranges::find(method_.levels, trial.presented.level);
    SPRINGDRIVE_ASSERT(found != method_.levels.end());
    const auto row = proportions_.row(found - method_.levels.begin()).transpose().array();
    posterior_.array() *= trial.outcome.positive ? row.eval() : (1.0 - row).eval();
    posterior_ /= posterior_.sum();
    ++trials_;
}

PsychometricFunction QuestPlusRun::mean() const {
    PsychometricFunction mean{method_.family, 0.0, 0.0, 0.0, 0.0};
    for (std::size_t j = 0; j < functions_.size(); ++j) {
        const double weight = posterior_[static_cast<Eigen::Index>(j)];
        const PsychometricFunction &function = functions_[j];
        mean.threshold += weight * on_scale(method_.threshold.prior.scale, function.threshold);
        mean.slope += weight * on_scale(method_.slope.prior.scale, function.slope);
        mean.guess += weight * function.guess;
        mean.lapse += weight * function.lapse;
    }
    mean.threshold = level_from(method_.threshold.prior.scale, mean.threshold);
    mean.slope = level_from(method_.slope.prior.scale, mean.slope);
    return mean;
}

double QuestPlusRun::threshold_deviation() const {
    const Scale scale = method_.threshold.prior.scale;
    const double mean_u = on_scale(scale, mean().threshold);
    double variance = 0.0;
    for (std::size_t j = 0; j < functions_.size(); ++j) {
        const double off = on_scale(scale, functions_[j].threshold) - mean_u;
        variance += posterior_[static_cast<Eigen::Index>(j)] * off * off;
    }
    return std::sqrt(variance);
}

double QuestPlusRun::entropy() const {
    return -posterior_.unaryExpr([](double p) { return p > 0.0 ? p * std::log(p) : 0.0; }).sum();
}

Eigen::VectorXd QuestPlusRun::information() const {
    const Eigen::VectorXd positive = proportions_ * posterior_;
    return positive.unaryExpr(&answer_entropy) - answer_entropies_ * posterior_;
}

Eigen::VectorXd QuestPlusRun::expected_entropy() const {
    return Eigen::VectorXd::Constant(proportions_.rows(), entropy()) - information();
}

std::string validate(const Method &method, const Task &task) {
    if (std::holds_alternative<Adjustment>(method) != (task.kind == TaskKind::adjustment)) {
        return fmt::format("method is {} and the task is {}; adjustment is both or neither",
                           kMethodNames[method.index()],
                           kTaskKindNames[static_cast<std::size_t>(task.kind)]);
    }
    return std::visit(
        [&](const auto &one) {
            const std::string error = validate(one);
            return error.empty() ? validate_task(one, task) : error;
        },
        method);
}

int max_trials(const Method &method) {
    return std::visit([](const auto &one) { return max_trials(one); }, method);
}

MethodRun::MethodRun(const Method &method, RandomKey key)
    : run_(std::visit([key](const auto &one) { return started(one, key); }, method)) {}

bool MethodRun::is_done() const {
    return std::visit([](const auto &run) { return run.is_done(); }, run_);
}

std::optional<MethodTrial> MethodRun::next() const {
    return std::visit([](const auto &run) { return run.next(); }, run_);
}

void MethodRun::add(const PastMethodTrial &trial) {
    std::visit([&](auto &run) { run.add(trial); }, run_);
}

} // namespace springdrive::study

#include "engine/study/methods/quest_plus.h"

#include "base/assertions.h"
#include "engine/study/methods/wrong_value.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace springdrive::study {

namespace {

/// h(ψ) [nat].
double answer_entropy(double proportion) {
    return -proportion * std::log(proportion) - (1.0 - proportion) * std::log1p(-proportion);
}

} // namespace

FunctionPriors priors_of(const QuestPlus &method) {
    return {method.family, method.threshold.prior, method.slope.prior, method.guess.prior,
            method.lapse.prior};
}

std::string validate(const QuestPlus &method) {
    constexpr double kMaxPoints = kPriorAxisFields.front().range.maximum;
    const double cells = static_cast<double>(method.levels.size()) * method.threshold.points *
                         method.slope.points * method.guess.points * method.lapse.points;
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
         unless_from_to("levels times all points", cells, 1.0, kMaxQuestTable),
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

} // namespace springdrive::study

#include "engine/study/analysis/scoring.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace springdrive::study {

namespace {

constexpr Eigen::Index kParameters = 4;

struct Slopes {
    double log_likelihood = 0.0;
    Coordinates gradient = Coordinates::Zero();
    Eigen::Matrix4d information = Eigen::Matrix4d::Zero(); ///< Fisher's, expected
};

Slopes slopes_at(std::span<const LevelCount> counts, const ScoredModel &model,
                 const Coordinates &at) {
    Slopes slopes;
    const double beta = std::exp(at[1]);
    const double guess = at[2];
    const double free_share = 1.0 - guess - at[3];
    for (const LevelCount &count : counts) {
        const double off = on_scale(model.family.scale, count.level) - at[0];
        const bool is_no_stimulus = std::isinf(off); // level 0 on a logarithmic scale
        const double z = beta * off + model.core_argument;
        const double core = core_proportion(model.family.shape, z);
        const double density =
            is_no_stimulus ? 0.0 : free_share * beta * core_density(model.family.shape, z);
        const double psi = possible_proportion(guess + free_share * core);
        const Coordinates by(-density, is_no_stimulus ? 0.0 : density * off, 1.0 - core, -core);
        const double variance = psi * (1.0 - psi);
        slopes.log_likelihood += likelihood_term(count, psi);
        slopes.gradient += by * ((count.positive - count.trials * psi) / variance);
        slopes.information += by * by.transpose() * (count.trials / variance);
    }
    return slopes;
}

/// The damped step in the coordinates that are free; 0 in the others.
Coordinates step_of(const Slopes &slopes, const std::array<bool, 4> &fixed, double damping) {
    Eigen::Matrix4d matrix = slopes.information;
    Coordinates gradient = slopes.gradient;
    for (Eigen::Index i = 0; i < kParameters; ++i) {
        constexpr double kMin = 1e-12; // where no trial tells anything of a coordinate
        matrix(i, i) += damping * matrix(i, i) + kMin;
        if (fixed[static_cast<std::size_t>(i)]) {
            matrix.row(i).setZero();
            matrix.col(i).setZero();
            matrix(i, i) = 1.0;
            gradient[i] = 0.0;
        }
    }
    return matrix.ldlt().solve(gradient);
}

/// The parameter is held, or lies at an end of its range and would leave it.
std::array<bool, 4> fixed_at(const ScoredModel &model, const Coordinates &at,
                             const Coordinates &gradient, const std::array<bool, 4> &held) {
    std::array<bool, 4> fixed = held;
    for (std::size_t i = 0; i < fixed.size(); ++i) {
        const auto j = static_cast<Eigen::Index>(i);
        fixed[i] = fixed[i] || (at[j] <= model.lowest[j] && gradient[j] <= 0.0) ||
                   (at[j] >= model.highest[j] && gradient[j] >= 0.0);
    }
    return fixed;
}

/// Nodes of the coarse grid in one coordinate.
std::vector<double> coarse_nodes(double lowest, double highest, int count) {
    if (lowest == highest) {
        return {lowest};
    }
    std::vector<double> nodes;
    for (int i = 0; i < count; ++i) {
        nodes.push_back(lowest + (highest - lowest) * (i + 0.5) / count);
    }
    return nodes;
}

} // namespace

ScoredModel model_at(const FunctionPriors &priors, double core) {
    const Scale scale = priors.family.scale;
    ScoredModel model;
    model.family = priors.family;
    const double at_threshold = core_at_threshold(priors.family.shape);
    model.core_argument = core == at_threshold ? 0.0 : core_argument(priors.family.shape, core);
    const double farthest = model.core_argument / priors.slope.minimum;
    model.lowest = {on_scale(scale, priors.threshold.minimum) + std::min(0.0, farthest),
                    std::log(priors.slope.minimum), priors.guess.minimum, priors.lapse.minimum};
    model.highest = {on_scale(scale, priors.threshold.maximum) + std::max(0.0, farthest),
                     std::log(priors.slope.maximum), priors.guess.maximum, priors.lapse.maximum};
    return model;
}

PsychometricFunction function_at(const ScoredModel &model, const Coordinates &at) {
    const double beta = std::exp(at[1]);
    return {model.family, level_from(model.family.scale, at[0] - model.core_argument / beta), beta,
            at[2], at[3]};
}

Scored scored_from(std::span<const LevelCount> counts, const ScoredModel &model,
                   const Coordinates &start, const std::array<bool, 4> &held) {
    constexpr int kMaxSteps = 200;
    constexpr double kMinGain = 1e-13;
    constexpr double kMaxDamping = 1e12;
    Coordinates at = start.cwiseMax(model.lowest).cwiseMin(model.highest);
    Slopes slopes = slopes_at(counts, model, at);
    double damping = 1e-3;
    for (int i = 0; i < kMaxSteps && damping < kMaxDamping; ++i) {
        const std::array<bool, 4> fixed = fixed_at(model, at, slopes.gradient, held);
        const Coordinates step = step_of(slopes, fixed, damping);
        if (slopes.gradient.dot(step) < kMinGain) {
            break;
        }
        const Coordinates next = (at + step).cwiseMax(model.lowest).cwiseMin(model.highest);
        const Slopes there = slopes_at(counts, model, next);
        if (there.log_likelihood > slopes.log_likelihood) {
            at = next;
            slopes = there;
            damping *= 0.1;
        } else {
            damping *= 10.0;
        }
    }
    return {at, slopes.log_likelihood};
}

Scored scored_best(std::span<const LevelCount> counts, const ScoredModel &model,
                   const std::array<bool, 4> &held, const Coordinates &held_at) {
    constexpr std::array<int, 4> kNodes{16, 8, 2, 2};
    constexpr std::size_t kStarts = 4;
    std::array<std::vector<double>, 4> nodes;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const auto j = static_cast<Eigen::Index>(i);
        nodes[i] = held[i] ? std::vector<double>{held_at[j]}
                           : coarse_nodes(model.lowest[j], model.highest[j], kNodes[i]);
    }
    std::vector<Scored> starts;
    for (const double u : nodes[0]) {
        for (const double log_beta : nodes[1]) {
            for (const double guess : nodes[2]) {
                for (const double lapse : nodes[3]) {
                    const Coordinates at(u, log_beta, guess, lapse);
                    starts.push_back({at, log_likelihood(function_at(model, at), counts)});
                }
            }
        }
    }
    const auto tried = static_cast<std::ptrdiff_t>(std::min(kStarts, starts.size()));
    std::ranges::partial_sort(starts, starts.begin() + tried, std::ranges::greater(),
                              &Scored::log_likelihood);
    Scored best{starts.front().at, -std::numeric_limits<double>::max()};
    for (std::ptrdiff_t i = 0; i < tried; ++i) {
        const Scored reached =
            scored_from(counts, model, starts[static_cast<std::size_t>(i)].at, held);
        best = reached.log_likelihood > best.log_likelihood ? reached : best;
    }
    return best;
}

} // namespace springdrive::study

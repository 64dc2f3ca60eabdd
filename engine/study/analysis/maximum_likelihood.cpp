#include "engine/study/analysis/maximum_likelihood.h"

#include "base/assertions.h"
#include "base/bisection.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cstdint>
#include <map>

namespace springdrive::study {

namespace {

// Maximises the likelihood of a psychometric function, some parameters of which may be held.

/// What is maximised over: u of the level at which F is `core`, ln β, γ, λ.
using Coordinates = Eigen::Vector4d;

struct ScoredModel {
    FunctionFamily family;
    double core_argument = 0.0; ///< z where F is `core`; 0 at the threshold itself
    Coordinates lowest;
    Coordinates highest;
};

struct Scored {
    Coordinates at;
    double log_likelihood = 0.0;
};

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

/// @param core  which proportion of F the first coordinate is the level of. The range of its level
///              is that of the threshold, wider by what the flattest slope puts between both.
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

/// The parameters in their own units.
PsychometricFunction function_at(const ScoredModel &model, const Coordinates &at) {
    const double beta = std::exp(at[1]);
    return {model.family, level_from(model.family.scale, at[0] - model.core_argument / beta), beta,
            at[2], at[3]};
}

/// The maximum that is reached uphill from `start`, moved into the ranges.
/// @param held  coordinates that stay as they are
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

/// The best of those from the most likely nodes of a coarse grid over the ranges.
Scored scored_best(std::span<const LevelCount> counts, const ScoredModel &model,
                   const std::array<bool, 4> &held = {},
                   const Coordinates &held_at = Coordinates::Zero()) {
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

/// One end of the profile's interval of a coordinate.
struct ProfileEnd {
    double at = 0.0;
    bool is_open = false;
};

/// Follows the profile from the maximum to an end of the range.
class Profile {
public:
    Profile(std::span<const LevelCount> counts, const ScoredModel &model, Eigen::Index coordinate,
            double confidence)
        : counts_(counts), model_(model), coordinate_(coordinate),
          best_(scored_best(counts, model)) {
        held_[static_cast<std::size_t>(coordinate)] = true;
        // χ² with one degree of freedom is the square of a normal value.
        const double z = core_argument(Shape::cumulative_normal, 0.5 + 0.5 * confidence);
        lowest_log_likelihood_ = best_.log_likelihood - 0.5 * z * z;
    }

    [[nodiscard]] ProfileEnd end(double range_end) const {
        const double from = best_.at[coordinate_];
        if (from == range_end || holds(range_end)) {
            return {range_end, true};
        }
        constexpr int kHalvings = 45;
        return {bisect({from, range_end}, kHalvings, [this](double value) { return holds(value); })
                    .holds_at,
                false};
    }

private:
    [[nodiscard]] bool holds(double value) const {
        // The profile may have several maxima, so it is tried from the fit and from a grid.
        Coordinates start = best_.at;
        start[coordinate_] = value;
        return scored_from(counts_, model_, start, held_).log_likelihood >=
                   lowest_log_likelihood_ ||
               scored_best(counts_, model_, held_, start).log_likelihood >= lowest_log_likelihood_;
    }

    std::span<const LevelCount> counts_;
    ScoredModel model_;
    Eigen::Index coordinate_;
    Scored best_;
    std::array<bool, 4> held_{};
    double lowest_log_likelihood_ = 0.0;
};

template <typename ToUnit>
ProfileInterval interval_of(std::span<const LevelCount> counts, const ScoredModel &model,
                            Eigen::Index coordinate, double confidence, const ToUnit &to_unit) {
    SPRINGDRIVE_ASSERT(confidence > 0.0 && confidence < 1.0);
    const Profile profile(counts, model, coordinate, confidence);
    const ProfileEnd low = profile.end(model.lowest[coordinate]);
    const ProfileEnd high = profile.end(model.highest[coordinate]);
    return {to_unit(low.at), to_unit(high.at), low.is_open, high.is_open};
}

/// k ln(k/expected), 0 without any.
double surprise(int count, double expected) {
    return count == 0 ? 0.0 : count * std::log(count / expected);
}

double pearson_statistic(const PsychometricFunction &function, std::span<const LevelCount> counts) {
    double sum = 0.0;
    for (const LevelCount &count : counts) {
        const double psi = possible_proportion(proportion_at(function, count.level));
        const double off = count.positive - count.trials * psi;
        sum += off * off / (count.trials * psi * (1.0 - psi));
    }
    return sum;
}

} // namespace

std::vector<LevelCount> counted(std::span<const PastMethodTrial> trials) {
    std::map<double, LevelCount> by_level;
    for (const PastMethodTrial &trial : trials) {
        if (!trial.outcome.marked) {
            LevelCount &count = by_level[trial.presented.level];
            count.level = trial.presented.level;
            count.positive += trial.outcome.positive ? 1 : 0;
            ++count.trials;
        }
    }
    std::vector<LevelCount> counts;
    for (const auto &[level, count] : by_level) {
        counts.push_back(count);
    }
    return counts;
}

double log_likelihood(const PsychometricFunction &function, std::span<const LevelCount> counts) {
    double sum = 0.0;
    for (const LevelCount &count : counts) {
        sum += likelihood_term(count, proportion_at(function, count.level));
    }
    return sum;
}

std::vector<LevelCount> simulated_counts(const PsychometricFunction &function,
                                         std::span<const LevelCount> design, RandomKey key) {
    std::vector<LevelCount> counts(design.begin(), design.end());
    std::uint64_t number = 0;
    for (LevelCount &count : counts) {
        const double proportion = proportion_at(function, count.level);
        count.positive = 0;
        for (int i = 0; i < count.trials; ++i) {
            count.positive += uniform(child(key, number++)) < proportion ? 1 : 0;
        }
    }
    return counts;
}

LikelihoodFit maximum_likelihood(std::span<const LevelCount> counts, const FunctionPriors &priors) {
    SPRINGDRIVE_ASSERT(!counts.empty());
    const ScoredModel model = model_at(priors, core_at_threshold(priors.family.shape));
    const Scored best = scored_best(counts, model);
    LikelihoodFit fit;
    fit.function = function_at(model, best.at);
    fit.log_likelihood = best.log_likelihood;
    for (std::size_t i = 0; i < fit.is_at_end.size(); ++i) {
        const auto j = static_cast<Eigen::Index>(i);
        const bool is_free = model.lowest[j] < model.highest[j];
        fit.free_parameters += is_free ? 1 : 0;
        fit.is_at_end[i] =
            is_free && (best.at[j] == model.lowest[j] || best.at[j] == model.highest[j]);
    }
    return fit;
}

ProfileInterval profile_interval(std::span<const LevelCount> counts, const FunctionPriors &priors,
                                 FunctionParameter parameter, double confidence) {
    if (parameter == FunctionParameter::threshold) {
        return profile_interval_at(counts, priors, core_at_threshold(priors.family.shape),
                                   confidence);
    }
    const ScoredModel model = model_at(priors, core_at_threshold(priors.family.shape));
    return interval_of(
        counts, model, static_cast<Eigen::Index>(parameter), confidence,
        [&](double at) { return parameter == FunctionParameter::slope ? std::exp(at) : at; });
}

ProfileInterval profile_interval_at(std::span<const LevelCount> counts,
                                    const FunctionPriors &priors, double core, double confidence) {
    const ScoredModel model = model_at(priors, core);
    return interval_of(counts, model, 0, confidence,
                       [&](double at) { return level_from(priors.family.scale, at); });
}

double deviance(const PsychometricFunction &function, std::span<const LevelCount> counts) {
    double sum = 0.0;
    for (const LevelCount &count : counts) {
        const double psi = possible_proportion(proportion_at(function, count.level));
        sum += surprise(count.positive, count.trials * psi) +
               surprise(count.trials - count.positive, count.trials * (1.0 - psi));
    }
    return 2.0 * sum;
}

GoodnessOfFit goodness_of_fit(const LikelihoodFit &fit, std::span<const LevelCount> counts,
                              const FunctionPriors &priors, RandomKey key, int simulated) {
    SPRINGDRIVE_ASSERT(simulated >= 1);
    GoodnessOfFit goodness;
    goodness.deviance = deviance(fit.function, counts);
    goodness.degrees_of_freedom =
        std::max(0, static_cast<int>(counts.size()) - fit.free_parameters);
    if (goodness.degrees_of_freedom > 0) {
        goodness.dispersion = pearson_statistic(fit.function, counts) / goodness.degrees_of_freedom;
    }
    int as_large = 1;
    for (int i = 0; i < simulated; ++i) {
        const std::vector<LevelCount> others =
            simulated_counts(fit.function, counts, child(key, static_cast<std::uint64_t>(i)));
        const double reached = deviance(maximum_likelihood(others, priors).function, others);
        as_large += reached >= goodness.deviance ? 1 : 0;
    }
    goodness.p_value = as_large / (simulated + 1.0);
    return goodness;
}

} // namespace springdrive::study

#include "engine/study/analysis/posterior.h"

#include "base/assertions.h"
#include "base/bisection.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace springdrive::study {

namespace {

/// The largest log weight at each node of one axis, over all others. The last axis changes fastest.
std::vector<double> best_along(const std::vector<double> &log_weights,
                               const std::array<std::size_t, 4> &sizes, std::size_t axis) {
    std::vector<double> best(sizes[axis], -std::numeric_limits<double>::max());
    std::size_t stride = 1;
    for (std::size_t i = axis + 1; i < sizes.size(); ++i) {
        stride *= sizes[i];
    }
    for (std::size_t i = 0; i < log_weights.size(); ++i) {
        double &so_far = best[(i / stride) % sizes[axis]];
        so_far = std::max(so_far, log_weights[i]);
    }
    return best;
}

/// Parts of a cell into which a marginal density is interpolated.
constexpr std::size_t kParts = 8;

/// The shares of the parts of each cell: the logarithm of the density, which is nearly a parabola,
/// is between nodes the cubic through the four nearest ones.
std::vector<double> shares_of_parts(const std::vector<double> &shares) {
    constexpr std::size_t kNodes = 4;
    constexpr double kMinShare = 1e-30; // a logarithm must be finite
    if (shares.size() < kNodes) {
        return shares;
    }
    std::vector<double> parts;
    double sum = 0.0;
    for (std::size_t part = 0; part < shares.size() * kParts; ++part) {
        const double x = (static_cast<double>(part) + 0.5) / kParts - 0.5; // nodes at 0, 1, 2 …
        const auto nearest = static_cast<std::ptrdiff_t>(std::floor(x)) - 1;
        const auto first = static_cast<std::size_t>(
            std::clamp<std::ptrdiff_t>(nearest, 0, std::ssize(shares) - std::ptrdiff_t{kNodes}));
        double log_density = 0.0;
        for (std::size_t i = first; i < first + kNodes; ++i) {
            double weight = 1.0; // Lagrange's
            for (std::size_t j = first; j < first + kNodes; ++j) {
                weight *= i == j ? 1.0
                                 : (x - static_cast<double>(j)) /
                                       (static_cast<double>(i) - static_cast<double>(j));
            }
            log_density += weight * std::log(std::max(shares[i], kMinShare));
        }
        parts.push_back(std::exp(log_density));
        sum += parts.back();
    }
    for (double &share : parts) {
        share /= sum;
    }
    return parts;
}

/// The share below x, in cells from the first one's start; even within each.
double share_below_cells(const std::vector<double> &shares, double x) {
    double below = 0.0;
    for (std::size_t i = 0; i < shares.size() && x > static_cast<double>(i); ++i) {
        below += shares[i] * std::min(1.0, x - static_cast<double>(i));
    }
    return below;
}

/// Where a share that grows from `first` to `last` reaches a value.
template <typename Share>
double where_reached(double first, double last, double value, const Share &share) {
    constexpr int kHalvings = 50;
    return bisect({first, last}, kHalvings, [&](double x) { return share(x) < value; }).middle();
}

PosteriorSummary summary_on_scale(Scale scale, double mean, double variance, double median,
                                  double low, double high) {
    return {level_from(scale, mean), std::sqrt(std::max(0.0, variance)), level_from(scale, median),
            level_from(scale, low), level_from(scale, high)};
}

} // namespace

Posterior::Axis Posterior::axis_of(const Prior &prior, const Range &range, int points) {
    Axis axis;
    axis.scale = prior.scale;
    axis.first = range.first;
    if (range.width() == 0.0) {
        axis.density = {1.0};
        return axis;
    }
    axis.width = range.width() / points;
    for (std::size_t i = 0; i < static_cast<std::size_t>(points); ++i) {
        const double z = (axis.node(i) - on_scale(prior.scale, prior.mean)) / prior.deviation;
        axis.density.push_back(prior.density == Density::uniform ? 1.0 : std::exp(-0.5 * z * z));
    }
    return axis;
}

std::vector<double> Posterior::log_weights(std::span<const LevelCount> counts) const {
    const auto &[thresholds, slopes, guesses, lapses] = axes_;
    // All lapse rates at once, in arrays: the logarithms take most of the time.
    const auto count = static_cast<Eigen::Index>(lapses.density.size());
    Eigen::ArrayXd lapse_rates(count);
    Eigen::ArrayXd lapse_weights(count);
    for (Eigen::Index l = 0; l < count; ++l) {
        const auto node = static_cast<std::size_t>(l);
        lapse_rates[l] = level_from(lapses.scale, lapses.node(node));
        lapse_weights[l] = std::log(lapses.density[node]);
    }
    Eigen::ArrayXd psi(count);
    Eigen::ArrayXd sum(count);
    std::vector<double> cores(counts.size());
    std::vector<double> log_weights;
    for (std::size_t t = 0; t < thresholds.density.size(); ++t) {
        const double threshold = level_from(thresholds.scale, thresholds.node(t));
        for (std::size_t s = 0; s < slopes.density.size(); ++s) {
            const PsychometricFunction core{family_, threshold,
                                            level_from(slopes.scale, slopes.node(s)), 0.0, 0.0};
            std::ranges::transform(counts, cores.begin(), [&](const LevelCount &one) {
                return proportion_at(core, one.level);
            });
            for (std::size_t g = 0; g < guesses.density.size(); ++g) {
                const double guess = level_from(guesses.scale, guesses.node(g));
                sum = lapse_weights +
                      std::log(thresholds.density[t] * slopes.density[s] * guesses.density[g]);
                for (std::size_t i = 0; i < counts.size(); ++i) {
                    psi = guess + (1.0 - guess - lapse_rates) * cores[i];
                    psi = psi.max(kMinProportion).min(1.0 - kMinProportion);
                    sum += counts[i].positive * psi.log() +
                           (counts[i].trials - counts[i].positive) * (1.0 - psi).log();
                }
                log_weights.insert(log_weights.end(), sum.begin(), sum.end());
            }
        }
    }
    return log_weights;
}

Posterior::Posterior(std::span<const LevelCount> counts, const FunctionPriors &priors)
    : family_(priors.family) {
    const std::array<Prior, 4> prior{priors.threshold, priors.slope, priors.guess, priors.lapse};
    Ranges ranges{};
    for (std::size_t i = 0; i < prior.size(); ++i) {
        ranges[i] = {on_scale(prior[i].scale, prior[i].minimum),
                     on_scale(prior[i].scale, prior[i].maximum)};
    }
    constexpr std::array<int, 4> kCoarse{24, 20, 6, 8};
    constexpr int kMaxZooms = 8;
    bool shrinks = true;
    for (int zoom = 0; zoom < kMaxZooms && shrinks; ++zoom) {
        lay_axes(prior, ranges, kCoarse);
        const Ranges zoomed = ranges_that_matter(log_weights(counts));
        shrinks = false;
        for (std::size_t i = 0; i < ranges.size(); ++i) {
            shrinks = shrinks || zoomed[i].width() < 0.8 * ranges[i].width();
        }
        ranges = zoomed;
    }
    constexpr std::array<int, 4> kFine{60, 36, 24, 24};
    lay_axes(prior, ranges, kFine);
    take_shares(log_weights(counts));
}

void Posterior::lay_axes(const std::array<Prior, 4> &priors, const Ranges &ranges,
                         const std::array<int, 4> &points) {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
        axes_[i] = axis_of(priors[i], ranges[i], points[i]);
    }
}

std::array<std::size_t, 4> Posterior::sizes() const {
    std::array<std::size_t, 4> sizes{};
    std::ranges::transform(axes_, sizes.begin(), [](const Axis &a) { return a.density.size(); });
    return sizes;
}

Posterior::Ranges Posterior::ranges_that_matter(const std::vector<double> &log_weights) const {
    constexpr double kNegligible = 14.0;
    const double most = *std::ranges::max_element(log_weights);
    Ranges ranges{};
    for (std::size_t i = 0; i < axes_.size(); ++i) {
        const std::vector<double> best = best_along(log_weights, sizes(), i);
        const auto matters = [&](double weight) { return weight > most - kNegligible; };
        const auto first = std::ranges::find_if(best, matters) - best.begin();
        const auto behind = best.rend() - std::find_if(best.rbegin(), best.rend(), matters);
        // A cell more on both sides: what lies between two nodes is not seen.
        const auto end_of = [&](std::ptrdiff_t cells) {
            const std::ptrdiff_t inside = std::clamp<std::ptrdiff_t>(cells, 0, std::ssize(best));
            return axes_[i].first + static_cast<double>(inside) * axes_[i].width;
        };
        ranges[i] = {end_of(first - 1), end_of(behind + 1)};
    }
    return ranges;
}

void Posterior::take_shares(std::vector<double> weights) {
    const double most = *std::ranges::max_element(weights);
    double total = 0.0;
    for (double &weight : weights) {
        weight = std::exp(weight - most);
        total += weight;
    }
    const std::array<std::size_t, 4> size = sizes();
    for (std::size_t i = 0; i < axes_.size(); ++i) {
        axes_[i].share.assign(size[i], 0.0);
    }
    share_of_threshold_and_slope_.assign(size[0] * size[1], 0.0);
    for (std::size_t i = 0; i < weights.size(); ++i) {
        const double share = weights[i] / total;
        std::size_t rest = i;
        for (std::size_t axis = size.size(); axis-- > 0; rest /= size[axis]) {
            axes_[axis].share[rest % size[axis]] += share;
        }
        share_of_threshold_and_slope_[i / (size[2] * size[3])] += share;
    }
    for (Axis &axis : axes_) {
        axis.share_of_parts = shares_of_parts(axis.share);
    }
}

const Posterior::Axis &Posterior::axis(FunctionParameter parameter) const {
    return axes_[static_cast<std::size_t>(parameter)];
}

PosteriorSummary Posterior::of(FunctionParameter parameter, double confidence) const {
    SPRINGDRIVE_ASSERT(confidence > 0.0 && confidence < 1.0);
    const Axis &of = axis(parameter);
    double mean = 0.0;
    for (std::size_t i = 0; i < of.share.size(); ++i) {
        mean += of.share[i] * of.node(i);
    }
    double variance = 0.0;
    for (std::size_t i = 0; i < of.share.size(); ++i) {
        variance += of.share[i] * (of.node(i) - mean) * (of.node(i) - mean);
    }
    const auto parts = static_cast<double>(of.share_of_parts.size());
    const auto quantile = [&](double share) {
        const double x = where_reached(
            0.0, parts, share, [&](double at) { return share_below_cells(of.share_of_parts, at); });
        return of.first + x / parts * (of.end() - of.first);
    };
    return summary_on_scale(of.scale, mean, variance, quantile(0.5),
                            quantile(0.5 - 0.5 * confidence), quantile(0.5 + 0.5 * confidence));
}

PosteriorSummary Posterior::of_level_at(double core, double confidence) const {
    SPRINGDRIVE_ASSERT(confidence > 0.0 && confidence < 1.0);
    const double z = core_argument(family_.shape, core);
    const Axis &thresholds = axis(FunctionParameter::threshold);
    const Axis &slopes = axis(FunctionParameter::slope);
    const auto share_of = [&](std::size_t t, std::size_t s) {
        return share_of_threshold_and_slope_[t * slopes.share.size() + s];
    };
    const auto from_threshold = [&](std::size_t s) {
        return z / level_from(slopes.scale, slopes.node(s));
    };
    const auto on_family = [&](double u) {
        return on_scale(family_.scale, level_from(thresholds.scale, u));
    };
    double mean = 0.0;
    double mean_square = 0.0;
    for (std::size_t t = 0; t < thresholds.share.size(); ++t) {
        for (std::size_t s = 0; s < slopes.share.size(); ++s) {
            const double u = on_family(thresholds.node(t)) + from_threshold(s);
            mean += share_of(t, s) * u;
            mean_square += share_of(t, s) * u * u;
        }
    }
    // Below u lies, of each slope, what has its threshold below u − z/β: whole cells and a part.
    const auto share_below_u = [&](double u) {
        double below = 0.0;
        for (std::size_t s = 0; s < slopes.share.size(); ++s) {
            const double level = level_from(family_.scale, u - from_threshold(s));
            for (std::size_t t = 0; t < thresholds.share.size(); ++t) {
                below +=
                    share_of(t, s) * thresholds.part_below(t, on_scale(thresholds.scale, level));
            }
        }
        return below;
    };
    const auto [least, most] =
        std::minmax({from_threshold(0), from_threshold(slopes.share.size() - 1)});
    const double first = on_family(thresholds.first) + least;
    const double last = on_family(thresholds.end()) + most;
    const auto quantile = [&](double share) {
        return where_reached(first, last, share, share_below_u);
    };
    return summary_on_scale(family_.scale, mean, mean_square - mean * mean, quantile(0.5),
                            quantile(0.5 - 0.5 * confidence), quantile(0.5 + 0.5 * confidence));
}

double Posterior::share_below(FunctionParameter parameter, double value) const {
    const Axis &of = axis(parameter);
    const double u = on_scale(of.scale, value);
    const auto parts = static_cast<double>(of.share_of_parts.size());
    return of.width > 0.0 ? share_below_cells(of.share_of_parts,
                                              (u - of.first) * parts / (of.end() - of.first))
                          : of.part_below(0, u);
}

double Posterior::Axis::part_below(std::size_t cell, double u) const {
    const double start = first + static_cast<double>(cell) * width;
    return width > 0.0 ? std::clamp((u - start) / width, 0.0, 1.0) : (u > start ? 1.0 : 0.0);
}

PsychometricFunction Posterior::mean() const {
    return {family_, of(FunctionParameter::threshold).mean, of(FunctionParameter::slope).mean,
            of(FunctionParameter::guess).mean, of(FunctionParameter::lapse).mean};
}

} // namespace springdrive::study

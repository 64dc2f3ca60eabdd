#include "engine/study/analysis/posterior.h"

#include "base/assertions.h"

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

/// u below which a share of the weight lies, spread evenly over each cell.
double quantile_of(double first, double width, const std::vector<double> &shares, double share) {
    double below = 0.0;
    for (std::size_t i = 0; i < shares.size(); ++i) {
        if (below + shares[i] >= share && shares[i] > 0.0) {
            return first + (static_cast<double>(i) + (share - below) / shares[i]) * width;
        }
        below += shares[i];
    }
    return first + static_cast<double>(shares.size()) * width;
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
    std::vector<double> log_weights;
    std::vector<double> cores(counts.size());
    for (std::size_t t = 0; t < thresholds.density.size(); ++t) {
        const double threshold = level_from(thresholds.scale, thresholds.node(t));
        for (std::size_t s = 0; s < slopes.density.size(); ++s) {
            const PsychometricFunction core{family_, threshold,
                                            level_from(slopes.scale, slopes.node(s)), 0.0, 0.0};
            std::ranges::transform(counts, cores.begin(), [&](const LevelCount &count) {
                return proportion_at(core, count.level);
            });
            for (std::size_t g = 0; g < guesses.density.size(); ++g) {
                const double guess = level_from(guesses.scale, guesses.node(g));
                for (std::size_t l = 0; l < lapses.density.size(); ++l) {
                    const double free_share =
                        1.0 - guess - level_from(lapses.scale, lapses.node(l));
                    double sum = std::log(thresholds.density[t] * slopes.density[s] *
                                          guesses.density[g] * lapses.density[l]);
                    for (std::size_t i = 0; i < counts.size(); ++i) {
                        sum += likelihood_term(counts[i], guess + free_share * cores[i]);
                    }
                    log_weights.push_back(sum);
                }
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
    constexpr int kMostZooms = 8;
    bool shrinks = true;
    for (int zoom = 0; zoom < kMostZooms && shrinks; ++zoom) {
        lay_axes(prior, ranges, kCoarse);
        const Ranges zoomed = ranges_that_matter(log_weights(counts));
        shrinks = false;
        for (std::size_t i = 0; i < ranges.size(); ++i) {
            shrinks = shrinks || zoomed[i].width() < 0.8 * ranges[i].width();
        }
        ranges = zoomed;
    }
    constexpr std::array<int, 4> kFine{64, 40, 12, 16};
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
    constexpr double kNegligible = 18.0;
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
    const auto quantile = [&](double share) {
        return quantile_of(of.first, of.width, of.share, share);
    };
    return summary_on_scale(of.scale, mean, variance, quantile(0.5),
                            quantile(0.5 - 0.5 * confidence), quantile(0.5 + 0.5 * confidence));
}

PosteriorSummary Posterior::of_level_at(double core, double confidence) const {
    SPRINGDRIVE_ASSERT(confidence > 0.0 && confidence < 1.0);
    const double z = core_argument(family_.shape, core);
    const auto &[thresholds, slopes, guesses, lapses] = axes_;
    struct Node {
        double u = 0.0;
        double share = 0.0;
    };
    std::vector<Node> nodes;
    double mean = 0.0;
    for (std::size_t t = 0; t < thresholds.share.size(); ++t) {
        const double u_threshold =
            on_scale(family_.scale, level_from(thresholds.scale, thresholds.node(t)));
        for (std::size_t s = 0; s < slopes.share.size(); ++s) {
            const double u = u_threshold + z / level_from(slopes.scale, slopes.node(s));
            nodes.push_back({u, share_of_threshold_and_slope_[t * slopes.share.size() + s]});
            mean += nodes.back().u * nodes.back().share;
        }
    }
    double variance = 0.0;
    for (const Node &node : nodes) {
        variance += node.share * (node.u - mean) * (node.u - mean);
    }
    std::ranges::sort(nodes, {}, &Node::u);
    // Half the share of a node lies before it; between two nodes the share grows evenly.
    std::vector<double> below;
    double sum = 0.0;
    for (const Node &node : nodes) {
        below.push_back(sum + 0.5 * node.share);
        sum += node.share;
    }
    const auto quantile = [&](double share) {
        const auto next = std::ranges::lower_bound(below, share) - below.begin();
        const auto i =
            static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(next, 1, std::ssize(below) - 1));
        const double step = below[i] - below[i - 1];
        const double part = step > 0.0 ? std::clamp((share - below[i - 1]) / step, 0.0, 1.0) : 0.0;
        return std::lerp(nodes[i - 1].u, nodes[i].u, part);
    };
    return summary_on_scale(family_.scale, mean, variance, quantile(0.5),
                            quantile(0.5 - 0.5 * confidence), quantile(0.5 + 0.5 * confidence));
}

double Posterior::share_below(FunctionParameter parameter, double value) const {
    const Axis &of = axis(parameter);
    const double u = on_scale(of.scale, value);
    double below = 0.0;
    for (std::size_t i = 0; i < of.share.size(); ++i) {
        const double start = of.first + static_cast<double>(i) * of.width;
        const double part = of.width > 0.0 ? (u - start) / of.width : (u > start ? 1.0 : 0.0);
        below += of.share[i] * std::clamp(part, 0.0, 1.0);
    }
    return below;
}

PsychometricFunction Posterior::mean() const {
    return {family_, of(FunctionParameter::threshold).mean, of(FunctionParameter::slope).mean,
            of(FunctionParameter::guess).mean, of(FunctionParameter::lapse).mean};
}

} // namespace springdrive::study

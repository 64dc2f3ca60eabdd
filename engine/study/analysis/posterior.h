// Psychometric functions by Bayes' rule: the posterior of all parameters on a grid, and what it
// says of each. Intervals are equal-tailed, so that they do not depend on the scale.
//
// The grid is the midpoint rule over the part of the priors' ranges in which the posterior density,
// along each parameter at its best, is above e^(−14) of its maximum; that part is found by zooming
// in from the whole ranges.
#pragma once

#include "engine/study/analysis/maximum_likelihood.h"
#include "engine/study/methods/psychometric_function.h"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace springdrive::study {

/// Of one parameter, in its unit. Mean and deviation are those of u, on the parameter's scale; the
/// mean is given as a level, so on a logarithmic scale it is the geometric mean.
struct PosteriorSummary {
    double mean = 0.0;
    double deviation_on_scale = 0.0;
    double median = 0.0;
    double low = 0.0; ///< of the interval
    double high = 0.0;
};

class Posterior {
public:
    /// @pre validate(priors) is empty
    Posterior(std::span<const LevelCount> counts, const FunctionPriors &priors);

    /// @pre 0 < confidence < 1, here and below
    [[nodiscard]] PosteriorSummary of(FunctionParameter parameter, double confidence = 0.95) const;

    /// Of the level at which F, without guesses and lapses, has the value `core`. @pre 0 < core < 1
    [[nodiscard]] PosteriorSummary of_level_at(double core, double confidence = 0.95) const;

    /// The share of the posterior below a value of the parameter.
    [[nodiscard]] double share_below(FunctionParameter parameter, double value) const;

    /// The function whose parameters are their posterior means.
    [[nodiscard]] PsychometricFunction mean() const;

private:
    /// The cells of one parameter, on its scale.
    struct Axis {
        Scale scale = Scale::linear;
        double first = 0.0;
        double width = 0.0;                 ///< of a cell; 0 of a known value
        std::vector<double> density;        ///< the prior's at each node
        std::vector<double> share;          ///< the posterior's in each cell, sum 1
        std::vector<double> share_of_parts; ///< the same, interpolated, in parts of each cell

        [[nodiscard]] double node(std::size_t i) const {
            return first + (static_cast<double>(i) + 0.5) * width;
        }
        [[nodiscard]] double end() const {
            return first + static_cast<double>(density.size()) * width;
        }
        /// The part of a cell that lies below u; a known value lies below all that is above it.
        [[nodiscard]] double part_below(std::size_t cell, double u) const;
    };

    struct Range {
        double first = 0.0;
        double last = 0.0;
        [[nodiscard]] double width() const { return last - first; }
    };
    using Ranges = std::array<Range, 4>;

    [[nodiscard]] static Axis axis_of(const Prior &prior, const Range &range, int points);
    void lay_axes(const std::array<Prior, 4> &priors, const Ranges &ranges,
                  const std::array<int, 4> &points);
    [[nodiscard]] std::array<std::size_t, 4> sizes() const;
    [[nodiscard]] std::vector<double> log_weights(std::span<const LevelCount> counts) const;
    [[nodiscard]] Ranges ranges_that_matter(const std::vector<double> &log_weights) const;
    void take_shares(std::vector<double> log_weights);
    [[nodiscard]] const Axis &axis(FunctionParameter parameter) const;

    FunctionFamily family_;
    std::array<Axis, 4> axes_;
    /// Of threshold and slope together, the slope changing fastest: sum 1.
    std::vector<double> share_of_threshold_and_slope_;
};

} // namespace springdrive::study

// What trials say without a fit, and what participants say as a group.
#pragma once

#include "engine/study/methods/method.h"
#include "engine/study/methods/psychometric_function.h"

#include <optional>
#include <span>
#include <vector>

namespace springdrive::study {

/// P(T <= t) of Student's distribution with a whole number of degrees of freedom: Abramowitz &
/// Stegun 1964, 26.7.3 and 26.7.4. @pre degrees_of_freedom >= 1
[[nodiscard]] double student_proportion(double t, int degrees_of_freedom);

/// Its inverse, for proportions from 0.5 up to 1 − 1e-9. @pre as above
[[nodiscard]] double student_quantile(double proportion, int degrees_of_freedom);

struct MeanSummary {
    double mean = 0.0;
    double deviation = 0.0;      ///< standard deviation of the values; 0 of a single one
    double standard_error = 0.0; ///< of the mean
    double low = 0.0;            ///< of Student's interval; ±∞ of a single value
    double high = 0.0;
    int values = 0;
};

/// @pre at least one value; 0 < confidence < 1
[[nodiscard]] MeanSummary mean_of(std::span<const double> values, double confidence = 0.95);

/// Of one track. The level belongs to the method's `convergence_proportion`, to within the bias
/// that its steps leave (method.h).
struct ReversalEstimate {
    double level = 0.0;              ///< the mean, on the scale, of the levels at reversals
    double deviation_on_scale = 0.0; ///< of these levels
    int reversals = 0;               ///< averaged
};

/// The first `left_out` reversals of each track are left out, and one more if the rest is odd, so
/// that there are as many peaks as valleys (Levitt 1971). Nothing for a track with less than two
/// left.
[[nodiscard]] std::vector<std::optional<ReversalEstimate>>
reversal_estimates(const Staircases &method, std::span<const PastMethodTrial> trials, int left_out);

/// Of the settings of an adjustment, all on its scale; nothing without any. Marked trials are left
/// out.
[[nodiscard]] std::optional<MeanSummary> settings_on_scale(const Adjustment &method,
                                                           std::span<const PastMethodTrial> trials,
                                                           double confidence = 0.95);

/// Weber's fraction of a just noticeable difference, (threshold − standard)/standard, from the
/// level of the comparison at threshold. @pre standard > 0
[[nodiscard]] inline double weber_fraction(double threshold, double standard) {
    return (threshold - standard) / standard;
}

/// Of one participant, on the scale on which thresholds are compared: u = x or ln x.
struct ParticipantEstimate {
    double value = 0.0;
    double standard_error = 0.0; ///< above 0
};

struct GroupSummary {
    double mean = 0.0;
    double standard_error = 0.0;
    double low = 0.0; ///< of the interval of the mean; ±∞ of a single participant
    double high = 0.0;
    double deviation_between = 0.0; ///< τ, of true values between participants
    double heterogeneity = 0.0;     ///< Cochran's Q
    int participants = 0;
};

/// Random effects: estimate i is N(μ, τ² + sᵢ²). τ² by Paule and Mandel (1982, J. Res. Natl. Bur.
/// Stand. 87, 377), which makes the weighted squares add up to their expectation, N − 1; the mean
/// is weighted with 1/(τ² + sᵢ²), and its standard error and Student's interval are those of
/// Hartung and Knapp (2001, Stat. Med. 20, 3875), never narrower than without them (Röver, Knapp &
/// Friede 2015, BMC Med. Res. Methodol. 15:99). Better for few participants than DerSimonian and
/// Laird's, whose interval is too narrow (Veroniki et al. 2016, Res. Synth. Methods 7, 55).
/// @pre at least one estimate; 0 < confidence < 1
[[nodiscard]] GroupSummary random_effects(std::span<const ParticipantEstimate> estimates,
                                          double confidence = 0.95);

} // namespace springdrive::study

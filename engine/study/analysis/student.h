// Means of few values, with Student's intervals.
#pragma once

#include <span>

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

} // namespace springdrive::study

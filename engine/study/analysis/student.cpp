#include "engine/study/analysis/student.h"

#include "base/assertions.h"
#include "base/bisection.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace springdrive::study {

double student_proportion(double t, int degrees_of_freedom) {
    SPRINGDRIVE_ASSERT(degrees_of_freedom >= 1);
    const double angle = std::atan(t / std::sqrt(degrees_of_freedom));
    const double cosine_squared = std::cos(angle) * std::cos(angle);
    const bool is_odd = degrees_of_freedom % 2 == 1;
    // A(t|ν): an odd ν has cos θ (1 + 2/3 cos² θ + …), an even one 1 + 1/2 cos² θ + …
    double term = is_odd ? std::cos(angle) : 1.0;
    double sum = 0.0;
    for (int i = is_odd ? 3 : 2; i <= degrees_of_freedom; i += 2) {
        sum += term;
        term *= cosine_squared * (i - 1.0) / i;
    }
    const double inside = is_odd ? (angle + std::sin(angle) * sum) * 2.0 * std::numbers::inv_pi
                                 : std::sin(angle) * sum;
    return 0.5 + 0.5 * inside;
}

double student_quantile(double proportion, int degrees_of_freedom) {
    constexpr double kBeyond = 1e9; // of one degree of freedom at 1 − 1e-9: 3e8
    SPRINGDRIVE_ASSERT(proportion >= 0.5 && proportion <= 1.0 - 1e-9);
    constexpr int kHalvings = 100;
    return bisect({0.0, kBeyond}, kHalvings,
                  [&](double t) { return student_proportion(t, degrees_of_freedom) < proportion; })
        .holds_at;
}

MeanSummary mean_of(std::span<const double> values, double confidence) {
    SPRINGDRIVE_ASSERT(!values.empty() && confidence > 0.0 && confidence < 1.0);
    const auto count = static_cast<double>(values.size());
    MeanSummary summary;
    summary.values = static_cast<int>(values.size());
    summary.mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
    if (values.size() == 1) {
        summary.low = -std::numeric_limits<double>::infinity();
        summary.high = std::numeric_limits<double>::infinity();
        return summary;
    }
    double squares = 0.0;
    for (const double value : values) {
        squares += (value - summary.mean) * (value - summary.mean);
    }
    summary.deviation = std::sqrt(squares / (count - 1.0));
    summary.standard_error = summary.deviation / std::sqrt(count);
    const double reach =
        student_quantile(0.5 + 0.5 * confidence, summary.values - 1) * summary.standard_error;
    summary.low = summary.mean - reach;
    summary.high = summary.mean + reach;
    return summary;
}

} // namespace springdrive::study

// Times of single calls, and their distribution.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <numeric>
#include <vector>

namespace springdrive::bench {

/// The time of `work` [ns], including the clock's own overhead.
template <typename Work> [[nodiscard]] double time_ns(const Work &work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const auto end = std::chrono::steady_clock::now();
    return std::chrono::duration<double, std::nano>(end - start).count();
}

/// The quantile at a share; 0 for an empty list.
[[nodiscard]] inline double quantile(std::vector<double> values, double share) {
    if (values.empty()) {
        return 0.0;
    }
    const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[static_cast<std::size_t>(at)];
}

inline constexpr int kRepeats = 3;

/// Each call's minimum of `kRepeats` identical runs, timed one whole run after another: this
/// excludes most of the machine's other load.
[[nodiscard]] inline std::vector<double> min_of_repeats(const std::vector<double> &times_ns) {
    const std::size_t calls = times_ns.size() / kRepeats;
    std::vector<double> min_ns(times_ns.begin(),
                               times_ns.begin() + static_cast<std::ptrdiff_t>(calls));
    for (std::size_t i = calls; i < times_ns.size(); ++i) {
        min_ns[i % calls] = std::min(min_ns[i % calls], times_ns[i]);
    }
    return min_ns;
}

[[nodiscard]] inline double mean(const std::vector<double> &values) {
    return values.empty() ? 0.0
                          : std::accumulate(values.begin(), values.end(), 0.0) /
                                static_cast<double>(values.size());
}

} // namespace springdrive::bench

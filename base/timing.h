// Takes the time of a piece of work several times over, and names the machine on which that was
// measured.
#pragma once

#include "base/assertions.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <istream>
#include <string>
#include <utility>
#include <vector>

namespace springdrive {

/// A time measured repeatedly: its minimum, median and maximum.
struct Cost {
    double min_ns = 0.0;
    double median_ns = 0.0;
    double max_ns = 0.0;
};

/// Keeps the compiler from removing work whose result is not used.
template <typename Value> inline void keep(const Value &value) noexcept {
    asm volatile("" : : "g"(&value) : "memory");
}

/// The minimum, median and maximum of times [ns].
/// @pre there is at least one
[[nodiscard]] inline Cost cost_of_times(std::vector<double> times_ns) {
    SPRINGDRIVE_ASSERT(!times_ns.empty());
    std::ranges::sort(times_ns);
    const std::size_t half = times_ns.size() / 2;
    const double median_ns =
        times_ns.size() % 2 == 1 ? times_ns[half] : 0.5 * (times_ns[half - 1] + times_ns[half]);
    return {times_ns.front(), median_ns, times_ns.back()};
}

/// What `work` costs for each of the `per` pieces that it is made of [ns]. It runs once beforehand,
/// so that caches and branch predictors know it, and then `repeats` times against the clock.
/// @pre `repeats` >= 1 and `per` > 0
template <typename Work> [[nodiscard]] Cost cost_of(int repeats, double per, const Work &work) {
    SPRINGDRIVE_ASSERT(repeats >= 1 && per > 0.0);
    work();
    std::vector<double> times_ns;
    for (int i = 0; i < repeats; ++i) {
        const auto start = std::chrono::steady_clock::now();
        work();
        const auto end = std::chrono::steady_clock::now();
        times_ns.push_back(std::chrono::duration<double, std::nano>(end - start).count() / per);
    }
    return cost_of_times(std::move(times_ns));
}

/// The processor's model and the number of available cores, as in "AMD EPYC (2 cores)".
[[nodiscard]] std::string machine_name();

/// The first model name in a file like /proc/cpuinfo; "unknown processor" if there is none.
[[nodiscard]] std::string processor_model(std::istream &cpuinfo);

} // namespace springdrive

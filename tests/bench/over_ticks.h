// Times a piece of work on one recorded tick after another, at several places.
#pragma once

#include "tests/bench/recorded_touch.h"

#include <benchmark/benchmark.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace springdrive::bench {

/// A benchmark's argument is the number of one of these; the table's last column has its name.
inline constexpr std::array kPlaces{"free",        "plate",        "organic",       "sphere shape",
                                    "sphere:1280", "sphere:81920", "sphere:1310720"};
inline constexpr std::int64_t kFirstPlace = 0;
inline constexpr std::int64_t kLastPlace = kPlaces.size() - 1;
inline constexpr std::int64_t kFree = 0;
inline constexpr std::int64_t kOrganic = 2;

/// A benchmark of `work` on a recorded touch.
template <auto work> void at_place(benchmark::State &state) {
    const char *place = kPlaces.at(static_cast<std::size_t>(state.range(0)));
    state.SetLabel(place);
    work(state, recorded_touch(place));
}

/// Cycles through the ticks from RecordedTouch::kBefore to `end`. `begin` prepares the first of
/// them and is not timed.
template <typename Begin, typename Work>
void over_ticks(benchmark::State &state, std::size_t end, const Begin &begin, const Work &work) {
    std::size_t tick = end;
    for ([[maybe_unused]] const auto iteration : state) {
        if (tick == end) {
            state.PauseTiming();
            begin();
            tick = RecordedTouch::kBefore;
            state.ResumeTiming();
        }
        benchmark::DoNotOptimize(work(tick++));
    }
}

} // namespace springdrive::bench

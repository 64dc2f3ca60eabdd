// A recorded touch of the simulated device, so that the cost of each step of a servo tick can be
// measured on realistic states, one recorded tick after another.
#pragma once

#include "engine/lab/rig/servo_rig.h"

#include <benchmark/benchmark.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace springdrive::bench {

struct RecordedTouch {
    /// Until the gains are up and the hand has reached its target; not measured.
    static constexpr std::size_t kBefore = 2500;
    static constexpr std::size_t kTicks = 8000; ///< with those before

    rig::Scenario scenario;
    // One for each tick.
    std::vector<device::Measurement> states;
    std::vector<servo::ServoSample> samples;

    /// Before its first tick; a new one follows the same path.
    [[nodiscard]] std::unique_ptr<rig::ServoRig> rig() const;
    /// Before the first tick that is measured.
    [[nodiscard]] std::unique_ptr<rig::ServoRig> rig_in_touch() const;
};

/// Recorded at the first request: "free", "plate", "organic", "sphere shape", or a name of
/// `test_surface_named`.
/// @throw std::runtime_error where the recorded touch is not as expected
[[nodiscard]] const RecordedTouch &recorded_touch(const std::string &name);

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

// The cost of a servo tick, whole and step by step, on the states of recorded touches: in free
// space, on shapes, and on meshes from a handful of triangles to more than a million.
//   build/release/servo_benchmark [--benchmark_filter=tick]
// The steps are in servo_steps.cpp.
#include "tests/bench/over_ticks.h"
#include "tests/bench/recorded_touch.h"

#include <benchmark/benchmark.h>

#include <array>
#include <cstddef>
#include <memory>

namespace {

using namespace springdrive;
using namespace springdrive::bench;

/// The servo and the device that it drives, closed loop.
void tick_and_device(benchmark::State &state, const RecordedTouch &touch) {
    std::unique_ptr<rig::ServoRig> rig;
    over_ticks(
        state, RecordedTouch::kTicks, [&] { rig = touch.rig_in_touch(); },
        [&](std::size_t /*tick*/) { return rig->tick(); });
}

/// The servo alone, on recorded measurements.
/// @param inputs  in turn, twenty ticks each
template <std::size_t count>
void update_with(benchmark::State &state, const RecordedTouch &touch,
                 const std::array<servo::ServoInputs, count> &inputs) {
    std::unique_ptr<rig::ServoRig> rig;
    over_ticks(
        state, RecordedTouch::kTicks,
        [&] {
            rig = touch.rig();
            for (std::size_t i = 0; i < RecordedTouch::kBefore; ++i) {
                rig->loop().update(touch.states[i], inputs[0]);
            }
        },
        [&](std::size_t tick) {
            return rig->loop().update(touch.states[tick], inputs[tick / 20 % count]);
        });
}

void tick(benchmark::State &state, const RecordedTouch &touch) {
    update_with<1>(state, touch, {touch.rig()->inputs});
}

/// A constantly moving slider: the law is evaluated twice in each tick, before the change and after
/// it.
void tick_while_tuning(benchmark::State &state, const RecordedTouch &touch) {
    servo::ServoInputs inputs = touch.rig()->inputs;
    inputs.tuning.K_P_V_per_rad = 5.9;
    update_with<2>(state, touch, {touch.rig()->inputs, inputs});
}

} // namespace

BENCHMARK(at_place<tick>)->Name("tick")->DenseRange(kFirstPlace, kLastPlace);
BENCHMARK(at_place<tick_while_tuning>)
    ->Name("tick_while_tuning")
    ->DenseRange(kFirstPlace, kLastPlace);
BENCHMARK(at_place<tick_and_device>)->Name("tick_and_device")->DenseRange(kFirstPlace, kLastPlace);

BENCHMARK_MAIN();

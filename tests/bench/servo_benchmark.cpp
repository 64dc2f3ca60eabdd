// What a servo tick costs, whole and step by step, on the states of recorded touches: in free
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
    std::unique_ptr<ServoRig> rig;
    over_ticks(
        state, RecordedTouch::kTicks,
        [&] {
            rig = std::make_unique<ServoRig>(touch.description, touch.path, touch.surface);
            for (std::size_t i = 0; i < RecordedTouch::kBefore; ++i) {
                rig->tick();
            }
        },
        [&](std::size_t /*tick*/) { return rig->tick(); });
}

/// The servo alone: what the device measured is known.
template <typename Inputs>
void update_with(benchmark::State &state, const RecordedTouch &touch, const Inputs &inputs_at) {
    std::unique_ptr<ServoRig> rig;
    over_ticks(
        state, RecordedTouch::kTicks,
        [&] {
            rig = std::make_unique<ServoRig>(touch.description, touch.path, touch.surface);
            for (std::size_t i = 0; i < RecordedTouch::kBefore; ++i) {
                rig->loop.update(touch.states[i], rig->sealed_inputs);
            }
        },
        [&](std::size_t tick) {
            return rig->loop.update(touch.states[tick], inputs_at(*rig, tick));
        });
}

void tick(benchmark::State &state, const RecordedTouch &touch) {
    update_with(state, touch,
                [](const ServoRig &rig, std::size_t /*tick*/) -> const servo::ServoInputs & {
                    return rig.sealed_inputs;
                });
}

/// A slider that never rests: each tick the law is asked twice, before the change and after it.
void tick_while_tuning(benchmark::State &state, const RecordedTouch &touch) {
    std::array<servo::ServoInputs, 2> inputs;
    inputs[0].surface = &touch.surface;
    inputs[1] = inputs[0];
    inputs[1].tuning.K_P_V_per_rad = 5.9;
    for (servo::ServoInputs &sheet : inputs) {
        sheet = servo::sealed(sheet);
    }
    update_with(state, touch,
                [&](const ServoRig & /*rig*/, std::size_t tick) -> const servo::ServoInputs & {
                    return inputs[tick / 20 % inputs.size()];
                });
}

} // namespace

BENCHMARK(at_place<tick>)->Name("tick")->DenseRange(kFirstPlace, kLastPlace);
BENCHMARK(at_place<tick_while_tuning>)
    ->Name("tick_while_tuning")
    ->DenseRange(kFirstPlace, kLastPlace);
BENCHMARK(at_place<tick_and_device>)->Name("tick_and_device")->DenseRange(kFirstPlace, kLastPlace);

BENCHMARK_MAIN();

// The cost of a servo tick, whole and step by step, on the states of recorded touches: in free
// space, on shapes, and on meshes from a handful of triangles to more than a million.
//   build/release/servo_benchmark [--benchmark_filter=tick]
// The details of motion_control_benchmark and proxy_benchmark are one step here.
#include "base/hand_over.h"
#include "engine/control/force_direction.h"
#include "engine/servo/bumpless_transfer.h"
#include "engine/servo/command_limiter.h"
#include "tests/bench/recorded_touch.h"
#include "tests/bench/touch_path.h"

#include <benchmark/benchmark.h>

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

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

/// Few enough for a step's inputs to stay in the processor's cache, as they do within a tick.
constexpr std::size_t kEnd = RecordedTouch::kBefore + 1000;

void nothing() {}

control::Configuration configuration_of(const control::HapticLaw &law,
                                        const servo::ServoSample &sample) {
    return law.configuration(sample.theta_rad, sample.theta_rate_rad_per_s);
}

std::vector<control::Configuration> configurations(const control::HapticLaw &law,
                                                   const RecordedTouch &touch) {
    std::vector<control::Configuration> all;
    for (const servo::ServoSample &sample : touch.samples) {
        all.push_back(configuration_of(law, sample));
    }
    return all;
}

void step_device(benchmark::State &state, const RecordedTouch &touch) {
    std::unique_ptr<rig::ServoRig> rig;
    over_ticks(
        state, RecordedTouch::kTicks, [&] { rig = touch.rig_in_touch(); },
        [&](std::size_t tick) { return rig->phantom().advance(touch.samples[tick - 1].command); });
}

void step_configuration(benchmark::State &state, const RecordedTouch &touch) {
    const control::HapticLaw law(touch.scenario.device);
    control::VelocityFilter filter;
    over_ticks(
        state, kEnd, [&] { filter.reset(touch.samples[RecordedTouch::kBefore - 1].theta_rad); },
        [&](std::size_t tick) {
            const Vector3 theta_rad = law.theta_rad(touch.states[tick].counts);
            const double pole = control::velocity_filter_pole(
                touch.samples[tick].tuning.lambda_rad_per_s, kServoPeriod_s);
            return law.configuration(theta_rad, filter.update(theta_rad, pole, kServoPeriod_s));
        });
}

void step_proxy(benchmark::State &state, const RecordedTouch &touch) {
    contact::Proxy proxy;
    over_ticks(
        state, RecordedTouch::kTicks,
        [&] {
            proxy.reset(touch.samples.front().tip_m);
            for (std::size_t i = 0; i < RecordedTouch::kBefore; ++i) {
                proxy.update(*touch.scenario.surface, touch.samples[i].tip_m);
            }
        },
        [&](std::size_t tick) {
            return proxy.update(*touch.scenario.surface, touch.samples[tick].tip_m);
        });
}

void step_law(benchmark::State &state, const RecordedTouch &touch) {
    const control::HapticLaw law(touch.scenario.device);
    const std::vector<control::Configuration> now = configurations(law, touch);
    over_ticks(state, kEnd, nothing, [&](std::size_t tick) {
        const servo::ServoSample &sample = touch.samples[tick];
        return law(now[tick], sample.contact, sample.tuning, sample.global_alpha_rad2_per_m2);
    });
}

/// The addition to a tick in which a tuning changes: angles and law once more, with the previous
/// tuning.
void step_carry_over(benchmark::State &state, const RecordedTouch &touch) {
    const control::HapticLaw law(touch.scenario.device);
    servo::BumplessTransfer transfer(touch.scenario.device, kServoPeriod_s);
    over_ticks(state, kEnd, nothing, [&](std::size_t tick) {
        const servo::ServoSample &sample = touch.samples[tick];
        control::VelocityFilter filter(touch.samples[tick - 1].theta_rad,
                                       touch.samples[tick - 1].theta_rate_rad_per_s);
        const double pole =
            control::velocity_filter_pole(sample.tuning.lambda_rad_per_s, kServoPeriod_s);
        const control::Configuration now = law.configuration(
            sample.theta_rad, filter.update(sample.theta_rad, pole, kServoPeriod_s));
        const control::LawOutcome before =
            law(now, sample.contact, sample.tuning, sample.global_alpha_rad2_per_m2);
        transfer.carry(sample.command.e_W_V, before.command.e_W_V, false, true);
        return transfer.transfer_offset_V();
    });
}

/// The safety monitor's input of each tick.
std::vector<servo::Observation> observations(const control::HapticLaw &law,
                                             const RecordedTouch &touch) {
    std::vector<servo::Observation> all;
    for (const servo::ServoSample &sample : touch.samples) {
        servo::Observation seen;
        seen.motors = sample.motor;
        seen.now = configuration_of(law, sample);
        seen.tip_force_N = sample.tip_force_N;
        seen.current_A = sample.current_A;
        seen.touching = sample.contact.touching;
        if (seen.touching) {
            seen.spring_force_N = control::static_tip_force(
                seen.now.J, law.static_stiffness_Nm_per_rad(sample.tuning),
                sample.theta_Sd_rad - sample.theta_rad);
            seen.spring_stretch_m = sample.contact.x0_m - sample.tip_m;
        }
        all.push_back(seen);
    }
    return all;
}

void step_safety_monitor(benchmark::State &state, const RecordedTouch &touch) {
    const std::vector<servo::Observation> seen =
        observations(control::HapticLaw(touch.scenario.device), touch);
    std::optional<servo::SafetyMonitor> monitor;
    over_ticks(
        state, kEnd,
        [&] {
            monitor.emplace(touch.scenario.device, kServoPeriod_s);
            for (std::size_t i = 0; i < RecordedTouch::kBefore; ++i) {
                monitor->pass(touch.samples[i].command, seen[i], {});
            }
        },
        [&](std::size_t tick) {
            return monitor->pass(touch.samples[tick].command, seen[tick], {});
        });
}

void step_limiter(benchmark::State &state, const RecordedTouch &touch) {
    const control::HapticLaw law(touch.scenario.device);
    const std::vector<control::Configuration> now = configurations(law, touch);
    over_ticks(state, kEnd, nothing, [&](std::size_t tick) {
        const servo::ServoSample &sample = touch.samples[tick];
        servo::LimiterInputs inputs{now[tick], sample.limits, 1.0, Vector3::Zero(), sample.motor};
        for (std::size_t j = 0; j < sample.winding.size(); ++j) {
            inputs.R_hat_limit_Ohm[static_cast<Eigen::Index>(j)] =
                sample.winding[j].R_hat_limit_Ohm;
        }
        return servo::limited(touch.scenario.device, sample.command, inputs);
    });
}

void step_energy_observer(benchmark::State &state, const RecordedTouch &touch) {
    const std::vector<servo::Observation> seen =
        observations(control::HapticLaw(touch.scenario.device), touch);
    servo::EnergyObserver observer(kServoPeriod_s);
    over_ticks(
        state, kEnd, [&] { observer.reset(); },
        [&](std::size_t tick) {
            const servo::Observation &now = seen[tick];
            observer.update(now.now.tip_m, now.tip_force_N,
                            servo::spring_energy_J(now.spring_force_N, now.spring_stretch_m, 1.0),
                            0.0, 0.03);
            return observer.generated_J();
        });
}

/// Into a ring as long as the record's: the memory is not in a cache.
void step_telemetry(benchmark::State &state, const RecordedTouch &touch) {
    SampleRing<servo::ServoSample> ring(32'768);
    over_ticks(
        state, kEnd, [&] { ring.drain([](const servo::ServoSample & /*sample*/) {}); },
        [&](std::size_t tick) { return ring.push(touch.samples[tick]); });
}

} // namespace

BENCHMARK(at_place<tick>)->Name("tick")->DenseRange(kFirstPlace, kLastPlace);
BENCHMARK(at_place<tick_while_tuning>)
    ->Name("tick_while_tuning")
    ->DenseRange(kFirstPlace, kLastPlace);
BENCHMARK(at_place<tick_and_device>)->Name("tick_and_device")->DenseRange(kFirstPlace, kLastPlace);
BENCHMARK(at_place<step_device>)->Name("step_device")->Arg(kFree)->Arg(kOrganic);
BENCHMARK(at_place<step_configuration>)->Name("step_configuration")->Arg(kFree)->Arg(kOrganic);
BENCHMARK(at_place<step_proxy>)->Name("step_proxy")->DenseRange(kFirstPlace, kLastPlace);
BENCHMARK(at_place<step_law>)->Name("step_law")->Arg(kFree)->Arg(kOrganic);
BENCHMARK(at_place<step_carry_over>)->Name("step_carry_over")->Arg(kFree)->Arg(kOrganic);
BENCHMARK(at_place<step_safety_monitor>)->Name("step_safety_monitor")->Arg(kFree)->Arg(kOrganic);
BENCHMARK(at_place<step_limiter>)->Name("step_limiter")->Arg(kFree)->Arg(kOrganic);
BENCHMARK(at_place<step_energy_observer>)->Name("step_energy_observer")->Arg(kFree)->Arg(kOrganic);
BENCHMARK(at_place<step_telemetry>)->Name("step_telemetry")->Arg(kFree)->Arg(kOrganic);

BENCHMARK_MAIN();

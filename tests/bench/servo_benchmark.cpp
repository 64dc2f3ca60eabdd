// The cost of a servo tick, whole and step by step, on the states of recorded touches: in free
// space, on shapes, and on meshes from a handful of triangles to more than a million.
//   build/release/servo_benchmark [--benchmark_filter=tick]
// The details of motion_control_benchmark and proxy_benchmark are one step here.
#include "base/hand_over.h"
#include "engine/control/rendered_force.h"
#include "engine/lab/rig/scenario/scenarios.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/lab/rig/servo_rig.h"
#include "engine/scene/scene.h"
#include "engine/servo/bumpless_transfer.h"
#include "engine/servo/command_limiter.h"
#include "tests/bench/touch_path.h"
#include "tests/support/devices.h"

#include <benchmark/benchmark.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::bench {

namespace {

/// A recorded touch of the simulated device, so that the cost of each step of a servo tick can be
/// measured on realistic states, one recorded tick after another.
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

constexpr double kHeightWhenFree_m = 0.02;

rig::Scenario in_scene(const rig::ScenarioSetting &setting, const std::string &name,
                       double depth_m) {
    const scene::Scene scene = rig::touch_scene(
        (testing::assets() / "scenes" / (name + ".gltf")).string(), setting.device.workspace);
    scene::ScriptedTouch how;
    how.depth_m = depth_m;
    return rig::scripted_touch_scenario(
        setting,
        {std::make_shared<contact::HapticSurface>(scene::haptic_surface_of(scene)), scene.lower_m,
         scene.upper_m},
        how);
}

/// From above onto the top, then along a figure that comes by everywhere in reach.
rig::Scenario on_sphere(const rig::ScenarioSetting &setting, contact::HapticSurface surface) {
    const Vector3 corner_m = Vector3::Constant(rig::kTestSphereRadius_m);
    const scene::ScriptedTouch how;
    rig::Scenario scenario = rig::scripted_touch_scenario(
        setting,
        {std::make_shared<contact::HapticSurface>(std::move(surface)), -corner_m, corner_m}, how);
    std::vector<simulated::HandPath::Point> points{{0.0, scenario.start_m},
                                                   {how.wait_s, scenario.start_m}};
    double time_s = how.wait_s + how.approach_s;
    for (const Vector3 &tip_m :
         pressed_tips_m(Relief::smooth, lissajous_directions(RecordedTouch::kTicks))) {
        points.push_back({time_s, tip_m});
        time_s += kServoPeriod_s;
    }
    scenario.simulation.path = simulated::HandPath(std::move(points));
    return scenario;
}

rig::Scenario scenario_named(const rig::ScenarioSetting &setting, const std::string &name) {
    if (name == "free") {
        return in_scene(setting, "plate", -kHeightWhenFree_m);
    }
    if (std::optional<contact::TriangleSoup> soup = rig::test_surface_named(name)) {
        return on_sphere(setting, contact::HapticSurface(std::move(*soup)));
    }
    if (name == "sphere shape") {
        contact::TriangleSoup material_only;
        material_only.materials = {{"sphere", 0.0}};
        return on_sphere(setting,
                         contact::HapticSurface(
                             std::move(material_only),
                             {contact::AnalyticShape(contact::Sphere{rig::kTestSphereRadius_m},
                                                     Eigen::Isometry3d::Identity(), 0)}));
    }
    return in_scene(setting, name, scene::ScriptedTouch{}.depth_m);
}

void check(const RecordedTouch &touch, const std::string &name) {
    std::size_t touching = 0;
    for (std::size_t i = RecordedTouch::kBefore; i < RecordedTouch::kTicks; ++i) {
        const servo::ServoSample &sample = touch.samples[i];
        touching += sample.contact.touching ? 1 : 0;
        if (sample.safety.state != servo::SafetyState::running) {
            throw std::runtime_error(
                name + ": the servo does not run: " + servo::description(sample.safety));
        }
    }
    const std::size_t measured = RecordedTouch::kTicks - RecordedTouch::kBefore;
    if (name == "free" ? touching > 0 : 10 * touching < 9 * measured) {
        throw std::runtime_error(name + ": " + std::to_string(touching) + " of " +
                                 std::to_string(measured) + " ticks in contact");
    }
}

std::unique_ptr<RecordedTouch> play(const std::string &name) {
    auto touch = std::make_unique<RecordedTouch>(
        RecordedTouch{scenario_named({testing::phantom_1_0(), {}}, name), {}, {}});
    const std::unique_ptr<rig::ServoRig> rig = touch->rig();
    for (std::size_t i = 0; i < RecordedTouch::kTicks; ++i) {
        touch->samples.push_back(rig->tick());
        touch->states.push_back(rig->measured());
    }
    check(*touch, name);
    return touch;
}

std::unique_ptr<rig::ServoRig> RecordedTouch::rig() const {
    return std::make_unique<rig::ServoRig>(scenario);
}

std::unique_ptr<rig::ServoRig> RecordedTouch::rig_in_touch() const {
    std::unique_ptr<rig::ServoRig> begun = rig();
    for (std::size_t i = 0; i < kBefore; ++i) {
        begun->tick();
    }
    return begun;
}

/// Recorded at the first request: "free", "plate", "organic", "sphere shape", or a name of
/// `test_surface_named`.
/// @throw std::runtime_error where the recorded touch is not as expected
[[nodiscard]] const RecordedTouch &recorded_touch(const std::string &name) {
    static std::map<std::string, std::unique_ptr<RecordedTouch>> played;
    std::unique_ptr<RecordedTouch> &touch = played[name];
    if (!touch) {
        touch = play(name);
    }
    return *touch;
}

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

} // namespace

} // namespace springdrive::bench

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

// The cost of control and plant on the servo thread: each step of the signal path from q to e_W
// over the workspace, and a sub-step of the simulated device.
#include "device/core/phantom/dynamics.h"
#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/control/motion_control.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <benchmark/benchmark.h>

#include <array>
#include <cstddef>
#include <random>

namespace {

using namespace springdrive;

/// The tip's configuration, and a set-point 1 mm away that moves at 0.1 m/s.
struct Place {
    Vector3 q_rad{Vector3::Zero()};
    control::Configuration now;
    control::TipSetPoint target;
};

/// The number of workspace points that a benchmark cycles through: enough to defeat branch
/// prediction.
constexpr std::size_t kPlaces = 1024;

const device::DeviceDescription &device() {
    static const device::DeviceDescription read = testing::phantom_1_0();
    return read;
}

std::array<Place, kPlaces> make_places() {
    std::mt19937_64 random(1);
    std::array<Place, kPlaces> places;
    for (Place &place : places) {
        place.q_rad = testing::random_workspace_angles(device(), random);
        place.now.theta_rad = device::motor_from_joint(device().geometry, place.q_rad);
        place.now.tip_m = device::tip_position_m(device().geometry, place.q_rad);
        place.now.J = device::motor_jacobian(device().geometry, place.q_rad);
        place.now.theta_rate_rad_per_s = testing::random_vector(random, 5.0);
        place.target = {place.now.tip_m + testing::random_vector(random, 1e-3),
                        testing::random_vector(random, 0.1)};
    }
    return places;
}

/// Times `work` on one point after another.
template <typename Work> void over_the_workspace(benchmark::State &state, const Work &work) {
    static const std::array<Place, kPlaces> places = make_places();
    std::size_t next = 0;
    for ([[maybe_unused]] const auto iteration : state) {
        const Place &place = places[next++ % kPlaces];
        benchmark::DoNotOptimize(work(place));
    }
}

void jacobian(benchmark::State &state) {
    over_the_workspace(
        state, [](const Place &at) { return device::motor_jacobian(device().geometry, at.q_rad); });
}

void alpha_on_the_fly(benchmark::State &state) {
    const Vector3 weights = control::relative_stiffness(device());
    over_the_workspace(state,
                       [&](const Place &at) { return control::alpha_bound(at.now.J, weights); });
}

/// Once, when a device is opened; a tick then costs nothing for α.
void alpha_global(benchmark::State &state) {
    for ([[maybe_unused]] const auto iteration : state) {
        benchmark::DoNotOptimize(control::global_alpha_bound(device()));
    }
}

void map_inverse(benchmark::State &state) {
    over_the_workspace(state, [](const Place &at) {
        return control::inverse_map(device().geometry, at.now, at.target);
    });
}

void map_transpose(benchmark::State &state) {
    const Vector3 weights = control::relative_stiffness(device());
    const double alpha = control::global_alpha_bound(device());
    over_the_workspace(state, [&](const Place &at) {
        return control::transpose_map(at.now, at.target, alpha, weights);
    });
}

void law(benchmark::State &state) {
    const Vector3 k_T = control::torque_constants(device());
    const control::Tuning tuning;
    over_the_workspace(state, [&](const Place &at) {
        return control::drift_compensation_V(k_T, tuning, at.now, control::no_force(at.now));
    });
}

void linkage_mass_matrix(benchmark::State &state) {
    const device::LinkageMoments moments =
        device::linkage_moments(device().geometry, device().inertia, 0.05);
    over_the_workspace(state,
                       [&](const Place &at) { return device::mass_matrix(moments, at.q_rad); });
}

/// A period of `range(0)` sub-steps with all effects, the tip driven by 0.3 V against a hand.
void plant(benchmark::State &state) {
    const auto steps = static_cast<double>(state.range(0));
    const double step_s = simulated::SimulationOptions{}.longest_step_s;
    simulated::SimulationOptions options;
    options.servo_period_s = steps * step_s;
    options.effects.structural_compliance = state.range(1) != 0;
    simulated::SimulatedPhantom phantom(device(), options, device().workspace.centre_m);
    const Vector3 R_hat_Ohm = Vector3::Constant(1.68);
    double period = 0.0;
    for ([[maybe_unused]] const auto iteration : state) {
        const Vector3 e_W_V =
            0.3 * std::sin(10.0 * period++ * options.servo_period_s) * Vector3(1.0, -1.0, 1.0);
        benchmark::DoNotOptimize(phantom.advance(device::DeviceCommand{e_W_V, R_hat_Ohm}));
    }
    state.counters["per_sub_step"] = benchmark::Counter(
        steps, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

} // namespace

BENCHMARK(jacobian);
BENCHMARK(alpha_on_the_fly);
BENCHMARK(alpha_global)->Unit(benchmark::kMillisecond);
BENCHMARK(map_inverse);
BENCHMARK(map_transpose);
BENCHMARK(law);
BENCHMARK(linkage_mass_matrix);
// Sub-steps in a period, and whether the structure is compliant.
BENCHMARK(plant)->Args({1, 0})->Args({1, 1})->Args({10, 0})->Args({10, 1});

BENCHMARK_MAIN();

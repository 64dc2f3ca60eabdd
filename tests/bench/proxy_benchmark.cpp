// What a proxy costs: time per servo tick while the tip slides over a sphere, and the time to
// prepare the mesh, over the number of triangles. Counters p50_ns and p99_ns are per update.
#include "engine/contact/proxy.h"
#include "tests/engine/contact/soups.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

namespace {

using namespace springdrive;

constexpr double kRadius_m = 0.05;

/// A tip 2 mm under the surface, at 0.3 m/s, on a path that covers the sphere.
Vector3 sliding_tip(int tick) {
    const double angle = 0.3 / kRadius_m * 1e-3 * tick;
    const Vector3 direction(std::cos(angle), std::sin(0.0137 * angle), std::sin(angle));
    return (kRadius_m - 2e-3) * direction.normalized();
}

void sliding_update(benchmark::State &state) {
    const HapticSurface mesh(testing::icosphere(static_cast<int>(state.range(0)), kRadius_m));
    Proxy proxy;
    proxy.reset(1.1 * sliding_tip(0));
    std::vector<double> times_ns;
    times_ns.reserve(1 << 22);
    int tick = 0;
    for ([[maybe_unused]] const auto iteration : state) {
        const Vector3 tip = sliding_tip(++tick);
        const auto start = std::chrono::steady_clock::now();
        benchmark::DoNotOptimize(proxy.update(mesh, tip));
        const auto end = std::chrono::steady_clock::now();
        times_ns.push_back(std::chrono::duration<double, std::nano>(end - start).count());
    }
    std::ranges::sort(times_ns);
    const auto quantile = [&](double share) {
        return times_ns[static_cast<std::size_t>(share * static_cast<double>(times_ns.size() - 1))];
    };
    state.counters["triangles"] = static_cast<double>(mesh.report().triangles_kept);
    state.counters["p50_ns"] = quantile(0.5);
    state.counters["p99_ns"] = quantile(0.99);
    state.counters["max_ns"] = quantile(1.0);
}

void prepare_sphere(benchmark::State &state) {
    const TriangleSoup soup = testing::icosphere(static_cast<int>(state.range(0)), kRadius_m);
    for ([[maybe_unused]] const auto iteration : state) {
        benchmark::DoNotOptimize(HapticSurface(soup));
    }
    state.counters["triangles"] = static_cast<double>(soup.triangles.size());
}

} // namespace

// Icospheres of 1,280, 20,480, 81,920 and 327,680 triangles.
BENCHMARK(sliding_update)->Arg(3)->Arg(5)->Arg(6)->Arg(7)->Iterations(200000);
BENCHMARK(prepare_sphere)->Arg(3)->Arg(5)->Arg(6)->Arg(7)->Unit(benchmark::kMillisecond);

BENCHMARK_MAIN();

// The cost of the proxy where many triangles meet in one vertex or edge, as one Markdown table on
// standard output. docs/proxy.md describes the columns.
#include "engine/contact/mesh/triangle_soup.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/contact/proxy/proxy.h"
#include "tests/bench/stopwatch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace springdrive;
using namespace springdrive::bench;
using contact::TriangleSoup;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kRadius_m = 5e-3;
constexpr int kTicks = 3000;

/// Heights and outline of a fan, relative to its radius.
struct FanShape {
    const char *name;
    double slope = 0.0;
    double wave = 0.0;   ///< twice around
    double rough = 0.0;  ///< of the height, at random
    double jagged = 0.0; ///< of the outline, at random
};

constexpr FanShape kFans[]{
    {"cap", 0.0, 0.0, 0.0, 0.2},
    {"cone", -0.3},
    {"pit", 0.3},
    {"saddle", 0.0, 0.2},
    {"jagged saddle", 0.0, 0.2, 0.0, 0.2},
    {"rough", 0.0, 0.0, 0.04},
    {"crumpled", 0.0, 0.0, 0.04, 0.2},
};
constexpr std::uint32_t kCounts[]{100, 1'000, 10'000, 50'000};

TriangleSoup with_material(TriangleSoup soup) {
    soup.material_of_triangle.assign(soup.triangles.size(), 0);
    soup.materials = {{"hard", 0.0}};
    return soup;
}

TriangleSoup fan_of(std::uint32_t count, const FanShape &shape) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> one(-1.0, 1.0);
    TriangleSoup soup;
    soup.vertices_m = {Vector3::Zero()};
    for (std::uint32_t i = 0; i < count; ++i) {
        const double phi = kTurn * i / count;
        const double out = 1.0 - shape.jagged * 0.5 * (1.0 + one(random));
        // The height does not follow the outline, so that a jagged rim makes a fan rough too,
        // unless it is flat.
        const double height =
            shape.slope + shape.wave * std::cos(2.0 * phi) + shape.rough * one(random);
        soup.vertices_m.emplace_back(kRadius_m *
                                     Vector3(out * std::cos(phi), height, out * std::sin(phi)));
        soup.triangles.push_back({0, 1 + (i + 1) % count, 1 + i});
    }
    return with_material(std::move(soup));
}

/// Pages about an edge, all around but for a tenth.
TriangleSoup book_of(std::uint32_t count) {
    TriangleSoup soup;
    soup.vertices_m = {{-kRadius_m, 0.0, 0.0}, {kRadius_m, 0.0, 0.0}};
    for (std::uint32_t i = 0; i < count; ++i) {
        const double phi = 0.9 * kTurn * i / count;
        soup.vertices_m.emplace_back(0.0, kRadius_m * std::cos(phi), kRadius_m * std::sin(phi));
        soup.triangles.push_back({0, 1, 2 + i});
    }
    return with_material(std::move(soup));
}

/// Down onto the surface, and around and across the vertex at 40 µm a tick.
std::vector<Vector3> tips_over_fan() {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> one(-1.0, 1.0);
    std::vector<Vector3> tips_m;
    for (int tick = 0; tick < kTicks; ++tick) {
        const double phi = 0.01 * tick;
        const double out_m = 4e-3 * std::sin(0.003 * tick) + 1e-5 * one(random);
        const double height_m =
            tick < 50 ? 3e-3 - 1e-4 * tick : -1e-3 - 5e-4 * std::sin(0.02 * tick);
        tips_m.emplace_back(out_m * std::cos(phi), height_m, out_m * std::sin(phi));
    }
    return tips_m;
}

/// By how much the proxy could be nearer to the tip [m], after as many updates as it takes.
double lag_m(contact::Proxy proxy, const contact::HapticSurface &surface, const Vector3 &tip_m,
             const Vector3 &proxy_m) {
    contact::Contact contact;
    for (int i = 0; i < 100; ++i) {
        contact = proxy.update(surface, tip_m);
        if (contact.settled) {
            break;
        }
    }
    return (proxy_m - tip_m).norm() - (contact.x0_m - tip_m).norm();
}

void print_row(const char *name, const TriangleSoup &soup, const std::vector<Vector3> &tips_m) {
    const std::size_t triangles = soup.triangles.size();
    const double preparation_ns = time_ns([&] { static_cast<void>(contact::HapticSurface(soup)); });
    const contact::HapticSurface surface(soup);
    std::vector<double> times_ns;
    int touching = 0;
    int unsettled = 0;
    double largest_lag_m = 0.0;
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
        contact::Proxy proxy;
        proxy.reset(tips_m.front());
        for (const Vector3 &tip_m : tips_m) {
            contact::Contact contact;
            times_ns.push_back(time_ns([&] { contact = proxy.update(surface, tip_m); }));
            if (repeat == 0) {
                touching += contact.touching ? 1 : 0;
                unsettled += contact.settled ? 0 : 1;
                if (!contact.settled) {
                    largest_lag_m =
                        std::max(largest_lag_m, lag_m(proxy, surface, tip_m, contact.x0_m));
                }
            }
        }
    }
    std::vector<double> floor_ns = min_of_repeats(times_ns);
    std::ranges::sort(floor_ns);
    const auto at_us = [&](double share) {
        return 1e-3 * floor_ns[static_cast<std::size_t>(share * (kTicks - 1))];
    };
    std::printf("| %s | %zu | %.3f | %.1f | %.2f / %.1f / %.1f / %.1f | %d of %d | %.0f |\n", name,
                triangles, 1e-9 * preparation_ns, 1e-6 * static_cast<double>(surface.bytes()),
                at_us(0.5), at_us(0.99), at_us(0.999), at_us(1.0), unsettled, touching,
                1e6 * largest_lag_m);
}

} // namespace

int main() {
    try {
        const std::vector<Vector3> tips_m = tips_over_fan();
        std::printf("| | triangles | preparation [s] | memory [MB] | update, floor: median / p99 / "
                    "p99.9 / max [µs] | unsettled | lag of those [µm] |\n"
                    "|:--|--:|--:|--:|:-:|--:|--:|\n");
        for (const FanShape &shape : kFans) {
            for (const std::uint32_t count : kCounts) {
                print_row(shape.name, fan_of(count, shape), tips_m);
            }
        }
        for (const std::uint32_t count : kCounts) {
            print_row("book", book_of(count), tips_m);
        }
    } catch (const std::exception &error) {
        std::fprintf(stderr, "fan_benchmark: %s\n", error.what());
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}

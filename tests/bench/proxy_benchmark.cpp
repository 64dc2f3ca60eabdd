// The cost of the proxy compared with Embree and FCL, as one Markdown table on standard output: a
// row for each of some surfaces of engine/lab/rig/scenario/test_surfaces.h. docs/proxy.md describes
// the columns.
//
// Embree and FCL are optional (libembree-dev, libfcl-dev); without them their columns say so.
#include "engine/contact/mesh/nearest.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "tests/bench/other_libraries.h"
#include "tests/bench/proxy_times.h"
#include "tests/bench/stopwatch.h"
#include "tests/bench/touch_path.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace springdrive;
using namespace springdrive::bench;

constexpr std::array<std::size_t, 5> kTriangles{1280, 20480, 81920, 327680, 1310720};
constexpr std::size_t kMaxQuickTriangles = 81920;
constexpr std::size_t kHardTriangles = 1'000'000;

struct Row {
    const char *shape; ///< as `test_surface_named` knows it
    Relief relief;
    std::size_t triangles;
};

std::vector<Row> all_rows() {
    std::vector<Row> rows;
    for (const std::size_t triangles : kTriangles) {
        rows.push_back({"sphere", Relief::smooth, triangles});
    }
    for (const std::size_t triangles : kTriangles) {
        rows.push_back({"bumpy", Relief::bumpy, triangles});
    }
    rows.push_back({"scan", Relief::scanned, kHardTriangles});
    rows.push_back({"cad", Relief::machined, kHardTriangles});
    return rows;
}

/// The least share of updates in contact: over the holes of a scan the tip is lifted.
double min_touching(Relief relief) {
    switch (relief) {
    case Relief::scanned:
        return 0.8;
    case Relief::machined:
        return 0.9999; // an update whose effort ended may have stopped above the surface
    default:
        return 1.0;
    }
}

/// The number of tips for each measurement, the path's first ones.
struct Counts {
    int updates = 200'000;
    std::size_t cold = 2'000;
    std::size_t closest = 20'000;
    std::size_t fcl = 1'000;
    std::size_t exact = 50; ///< also answered by trying every triangle
};
constexpr Counts kQuick{20'000, 200, 2'000, 100, 50};

/// The largest over all rows [m].
struct Errors {
    double embree_cast_m = 0.0;
    double embree_closest_m = 0.0;
    double fcl_m = 0.0;
};

constexpr const char *kNotBuilt = "not built";

std::vector<Vector3> first(const std::vector<Vector3> &tips_m, std::size_t count) {
    return {tips_m.begin(),
            tips_m.begin() + static_cast<std::ptrdiff_t>(std::min(count, tips_m.size()))};
}

std::string rounded(double value_ns) { return std::to_string(std::lround(value_ns)); }

std::string quantiles(const std::vector<double> &times_ns, std::initializer_list<double> shares) {
    std::string text;
    for (const double share : shares) {
        text += (text.empty() ? "" : " / ") + rounded(quantile(times_ns, share));
    }
    return text;
}

std::string mean_and_p99(const std::vector<double> &times_ns) {
    return rounded(mean(times_ns)) + " / " + quantiles(times_ns, {0.99});
}

/// By trying every triangle.
double surface_distance_m(const contact::TriangleSoup &soup, const Vector3 &tip_m) {
    double min_m = INFINITY;
    for (const auto &[a, b, c] : soup.triangles) {
        const contact::TrianglePoint nearest = contact::nearest_on_triangle(
            {soup.vertices_m[a], soup.vertices_m[b], soup.vertices_m[c]}, tip_m);
        min_m = std::min(min_m, (nearest.point_m - tip_m).norm());
    }
    return min_m;
}

/// The columns of the proxy.
void print_proxy(const contact::HapticSurface &surface, Relief relief, const Counts &counts) {
    const std::vector<Vector3> directions = lissajous_directions(counts.updates);
    const std::vector<Vector3> pressed_m = pressed_tips_m(relief, directions);
    const ProxyTimes pressed = time_proxy(surface, pressed_m);
    const ProxyTimes free = time_proxy(surface, free_tips_m(relief, directions));
    const std::vector<double> cold_ns = time_proxy_cold(surface, first(pressed_m, counts.cold));
    if (pressed.touching < min_touching(relief) || free.touching > 0.0) {
        throw std::logic_error("the path is not in contact throughout, or not free throughout: " +
                               std::to_string(pressed.touching) + " and " +
                               std::to_string(free.touching));
    }
    std::printf(" %s / %s | %s | %s | %s |", rounded(mean(pressed.floor_ns)).c_str(),
                quantiles(pressed.floor_ns, {0.5, 0.99, 0.999, 1.0}).c_str(),
                quantiles(pressed.raw_ns, {0.5, 0.99, 0.999}).c_str(),
                quantiles(free.floor_ns, {0.5}).c_str(), quantiles(cold_ns, {0.5}).c_str());
}

/// The columns of the other libraries.
void print_others(const contact::TriangleSoup &soup, Relief relief, const Counts &counts,
                  Errors &errors) {
    const std::vector<Vector3> tips_m =
        pressed_tips_m(relief, lissajous_directions(counts.updates));
    const auto embree = time_embree(soup, tips_m, counts.closest);
    const auto fcl = time_fcl(soup, tips_m, counts.fcl);
    for (std::size_t i = 0; i < counts.fcl; i += counts.fcl / counts.exact) {
        const double exact_m = surface_distance_m(soup, tips_m[i]);
        const auto widen = [&](double &error_m, const Answers &answers) {
            error_m = std::max(error_m, std::abs(answers.distances_m[i] - exact_m));
        };
        if (embree) {
            widen(errors.embree_closest_m, embree->closest);
        }
        if (fcl) {
            widen(errors.fcl_m, *fcl);
        }
    }
    std::string cast = kNotBuilt;
    std::string closest = kNotBuilt;
    if (embree) {
        cast = mean_and_p99(embree->cast_floor_ns);
        closest = mean_and_p99(embree->closest.floor_ns);
        errors.embree_cast_m = std::max(errors.embree_cast_m, embree->cast_error_m);
    }
    std::printf(" %s | %s | %s |\n", cast.c_str(), closest.c_str(),
                fcl ? mean_and_p99(fcl->floor_ns).c_str() : kNotBuilt);
}

void print_row(const Row &row, const Counts &counts, Errors &errors) {
    const contact::TriangleSoup soup =
        *rig::test_surface_named(std::string(row.shape) + ":" + std::to_string(row.triangles));
    contact::HapticSurface surface;
    const double preparation_ns = time_ns([&] { surface = contact::HapticSurface(soup); });
    std::printf("| %s | %zu | %.3f | %.1f |", row.shape, soup.triangles.size(),
                1e-9 * preparation_ns, 1e-6 * static_cast<double>(surface.bytes()));
    print_proxy(surface, row.relief, counts);
    print_others(soup, row.relief, counts, errors);
    std::fflush(stdout);
}

void print_head() {
    std::puts("| surface | triangles | preparation [s] | memory [MB] "
              "| contact, floor: mean / median / p99 / p99.9 / max [ns] "
              "| contact, raw: median / p99 / p99.9 [ns] | free [ns] | cold [ns] "
              "| Embree cast: mean / p99 [ns] | Embree closest: mean / p99 [ns] "
              "| FCL distance: mean / p99 [ns] |");
    std::puts("|:--|--:|--:|--:|:-:|:-:|--:|--:|:-:|:-:|:-:|");
}

void print_foot(const Counts &counts, const Errors &errors) {
    std::vector<double> nothing_ns(100'000);
    for (double &one_ns : nothing_ns) {
        one_ns = time_ns([] {});
    }
    std::printf("\nUpdates: %d; cold: %zu; Embree casts: %d, closest: %zu; FCL: %zu. "
                "The clock itself, in all of these: median %.0f ns.\n",
                counts.updates, counts.cold, counts.updates, counts.closest, counts.fcl,
                quantile(nothing_ns, 0.5));
    std::printf("Largest errors: Embree cast %.2g m, closest %.2g m; FCL %.2g m "
                "(closest and FCL: at %zu tips a row, against every triangle tried; "
                "0 where not built).\n",
                errors.embree_cast_m, errors.embree_closest_m, errors.fcl_m, counts.exact);
}

void run(bool quick, std::size_t only) {
    const Counts counts = quick ? kQuick : Counts{};
    Errors errors;
    print_head();
    for (const Row &row : all_rows()) {
        if (only == 0 ? !quick || row.triangles <= kMaxQuickTriangles : row.triangles == only) {
            print_row(row, counts, errors);
        }
    }
    print_foot(counts, errors);
}

} // namespace

int main(int argc, char **argv) {
    try {
        bool quick = false;
        std::size_t only = 0;
        CLI::App app("What the proxy costs, as a Markdown table.", "proxy_benchmark");
        app.add_flag("--quick", quick, "fewer updates, and up to 81920 triangles only");
        std::vector<std::size_t> sizes(kTriangles.begin(), kTriangles.end());
        sizes.push_back(kHardTriangles);
        app.add_option("--only", only, "surfaces of that many triangles only")
            ->check(CLI::IsMember(sizes));
        CLI11_PARSE(app, argc, argv);
        run(quick, only);
    } catch (const std::exception &error) {
        std::fprintf(stderr, "proxy_benchmark: %s\n", error.what());
        return 1;
    }
    return 0;
}

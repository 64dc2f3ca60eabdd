// The cost of the proxy compared with Embree and FCL, as one Markdown table on standard output: a
// row for each of some surfaces of engine/lab/rig/scenario/test_surfaces.h; or, with --fans, where
// many triangles meet in one vertex or edge. docs/proxy.md describes the columns.
//
// Embree and FCL are optional (libembree-dev, libfcl-dev); without them their columns say so.
#include "base/vector.h"
#include "engine/contact/mesh/facet.h"
#include "engine/contact/mesh/triangle_soup.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/contact/proxy/proxy.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "tests/bench/stopwatch.h"
#include "tests/bench/touch_path.h"

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <benchmark/benchmark.h>
#ifdef SPRINGDRIVE_HAS_EMBREE
#include <embree3/rtcore.h>
#endif
#ifdef SPRINGDRIVE_HAS_FCL
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision_object.h>
#include <fcl/narrowphase/distance.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <initializer_list>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace springdrive::bench {

namespace {

// Queries of the same surfaces by Embree and FCL, where those are installed: the cost of a query
// that is part of the proxy's work, and its accuracy.

/// The times and results of the queries.
struct Answers {
    std::vector<double> floor_ns; ///< its minimum of `kRepeats`, as for the proxy's updates
    std::vector<double> distances_m;
};

struct EmbreeTimes {
    /// Of a segment of 2 mm from the tip away from the origin.
    std::vector<double> cast_floor_ns;
    /// How far a hit lay from where the segment meets the plane of that triangle, at most [m].
    double cast_error_m = 0.0;
    /// Of the surface's point nearest to the tip, searched for at any distance.
    Answers closest;
};

/// Asks for the distance of each of the first `queries` tips, `kRepeats` times.
template <typename Distance>
[[maybe_unused]] Answers timed_answers(const std::vector<Vector3> &tips_m, std::size_t queries,
                                       const Distance &distance_m) {
    Answers answers;
    answers.distances_m.resize(std::min(queries, tips_m.size()));
    std::vector<double> times_ns;
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
        for (std::size_t i = 0; i < answers.distances_m.size(); ++i) {
            times_ns.push_back(time_ns([&] { answers.distances_m[i] = distance_m(tips_m[i]); }));
        }
    }
    answers.floor_ns = min_of_repeats(times_ns);
    return answers;
}

#ifdef SPRINGDRIVE_HAS_EMBREE
constexpr float kCastLength_m = 2e-3F;

using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, decltype(&rtcReleaseDevice)>;
using Scene = std::unique_ptr<std::remove_pointer_t<RTCScene>, decltype(&rtcReleaseScene)>;

Scene build_scene(RTCDevice device, const contact::TriangleSoup &soup) {
    Scene scene(rtcNewScene(device), &rtcReleaseScene);
    rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto *vertices = static_cast<float *>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), soup.vertices_m.size()));
    for (const Vector3 &vertex_m : soup.vertices_m) {
        Eigen::Map<Eigen::Vector3f>{vertices} = vertex_m.cast<float>();
        vertices += 3;
    }
    auto *indices = static_cast<std::uint32_t *>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(std::uint32_t), soup.triangles.size()));
    for (const auto &triangle : soup.triangles) {
        indices = std::ranges::copy(triangle, indices).out;
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene.get(), geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene.get());
    return scene;
}

RTCRayHit ray(const Vector3 &from_m, const Vector3 &direction) {
    const Eigen::Vector3f origin = from_m.cast<float>();
    const Eigen::Vector3f along = direction.cast<float>();
    RTCRayHit ray{};
    ray.ray.org_x = origin.x();
    ray.ray.org_y = origin.y();
    ray.ray.org_z = origin.z();
    ray.ray.dir_x = along.x();
    ray.ray.dir_y = along.y();
    ray.ray.dir_z = along.z();
    ray.ray.tfar = kCastLength_m;
    ray.ray.mask = ~0U;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    return ray;
}

/// Where a line meets a triangle's plane, in double precision [m from `from_m`].
double plane_distance_m(const contact::TriangleSoup &soup, std::size_t triangle,
                        const Vector3 &from_m, const Vector3 &direction) {
    const auto &[a, b, c] = soup.triangles[triangle];
    const Vector3 &corner_m = soup.vertices_m[a];
    const Vector3 normal =
        (soup.vertices_m[b] - corner_m).cross(soup.vertices_m[c] - corner_m).normalized();
    return normal.dot(corner_m - from_m) / normal.dot(direction);
}

void time_casts(RTCScene scene, const contact::TriangleSoup &soup,
                const std::vector<Vector3> &tips_m, EmbreeTimes &times) {
    std::vector<double> times_ns;
    times_ns.reserve(kRepeats * tips_m.size());
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
        for (const Vector3 &tip_m : tips_m) {
            const Vector3 outwards = tip_m.normalized();
            RTCRayHit found{};
            times_ns.push_back(time_ns([&] {
                RTCIntersectContext context{};
                rtcInitIntersectContext(&context);
                found = ray(tip_m, outwards);
                rtcIntersect1(scene, &context, &found);
            }));
            if (found.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
                const double exact_m = plane_distance_m(soup, found.hit.primID, tip_m, outwards);
                times.cast_error_m = std::max(
                    times.cast_error_m, std::abs(static_cast<double>(found.ray.tfar) - exact_m));
            }
        }
    }
    times.cast_floor_ns = min_of_repeats(times_ns);
}

struct Nearest {
    const contact::TriangleSoup *soup;
    Vector3 tip_m;
    double distance_m = INFINITY;
};

/// Embree finds the triangles that may be nearest and leaves their distance to its caller.
bool consider_triangle(RTCPointQueryFunctionArguments *requested) {
    auto &nearest = *static_cast<Nearest *>(requested->userPtr);
    const auto &[a, b, c] = nearest.soup->triangles[requested->primID];
    const auto &vertices_m = nearest.soup->vertices_m;
    const contact::TrianglePoint found =
        contact::nearest_on_triangle({vertices_m[a], vertices_m[b], vertices_m[c]}, nearest.tip_m);
    const double distance_m = (found.point_m - nearest.tip_m).norm();
    if (distance_m >= nearest.distance_m) {
        return false;
    }
    nearest.distance_m = distance_m;
    requested->query->radius = static_cast<float>(distance_m);
    return true;
}

double closest(RTCScene scene, const contact::TriangleSoup &soup, const Vector3 &tip_m) {
    Nearest nearest{&soup, tip_m};
    RTCPointQueryContext context{};
    rtcInitPointQueryContext(&context);
    const Eigen::Vector3f at = tip_m.cast<float>();
    RTCPointQuery query{at.x(), at.y(), at.z(), 0.0F, INFINITY};
    rtcPointQuery(scene, &query, &context, &consider_triangle, &nearest);
    return nearest.distance_m;
}
#endif

#ifdef SPRINGDRIVE_HAS_FCL
constexpr double kBallRadius_m = 1e-4;

using Model = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<Model> build_model(const contact::TriangleSoup &soup) {
    std::vector<fcl::Triangle> triangles;
    triangles.reserve(soup.triangles.size());
    for (const auto &[a, b, c] : soup.triangles) {
        triangles.emplace_back(a, b, c);
    }
    auto model = std::make_shared<Model>();
    model->beginModel();
    model->addSubModel(soup.vertices_m, triangles);
    model->endModel();
    return model;
}
#endif

/// Embree 3, robust, one thread; the first `closest_queries` tips only for the closest point.
/// Nothing where it is not built in.
std::optional<EmbreeTimes> time_embree([[maybe_unused]] const contact::TriangleSoup &soup,
                                       [[maybe_unused]] const std::vector<Vector3> &tips_m,
                                       [[maybe_unused]] std::size_t closest_queries) {
#ifdef SPRINGDRIVE_HAS_EMBREE
    const Device device(rtcNewDevice("threads=1"), &rtcReleaseDevice);
    const Scene scene = build_scene(device.get(), soup);
    EmbreeTimes times;
    time_casts(scene.get(), soup, tips_m, times);
    times.closest = timed_answers(tips_m, closest_queries, [&](const Vector3 &tip_m) {
        return closest(scene.get(), soup, tip_m);
    });
    return times;
#else
    return std::nullopt;
#endif
}

/// `fcl::distance` of a ball of 0.1 mm about the first `queries` tips to a BVHModel<OBBRSSd>, the
/// ball's radius added again. Nothing where it is not built in.
std::optional<Answers> time_fcl([[maybe_unused]] const contact::TriangleSoup &soup,
                                [[maybe_unused]] const std::vector<Vector3> &tips_m,
                                [[maybe_unused]] std::size_t queries) {
#ifdef SPRINGDRIVE_HAS_FCL
    const fcl::CollisionObjectd surface(build_model(soup));
    fcl::CollisionObjectd ball(std::make_shared<fcl::Sphered>(kBallRadius_m));
    const fcl::DistanceRequestd request;
    return timed_answers(tips_m, queries, [&](const Vector3 &tip_m) {
        ball.setTranslation(tip_m);
        ball.computeAABB();
        fcl::DistanceResultd result;
        return fcl::distance(&surface, &ball, request, result) + kBallRadius_m;
    });
#else
    return std::nullopt;
#endif
}

} // namespace

} // namespace springdrive::bench

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

constexpr std::size_t kSweptBytes = 96'000'000;
constexpr std::size_t kCacheLineBytes = 64;

/// A proxy that has moved to the first tip from outside.
contact::Proxy proxy_at(const contact::HapticSurface &surface, const Vector3 &tip_m) {
    contact::Proxy proxy;
    proxy.reset(1.5 * tip_m);
    benchmark::DoNotOptimize(proxy.update(surface, tip_m));
    return proxy;
}

/// Evicts everything else from the caches.
class Sweep {
public:
    void operator()() {
        for (std::size_t i = 0; i < swept_.size(); i += kCacheLineBytes) {
            ++swept_[i];
        }
        benchmark::ClobberMemory();
    }

private:
    std::vector<std::uint8_t> swept_ = std::vector<std::uint8_t>(kSweptBytes);
};

struct ProxyTimes {
    std::vector<double> floor_ns; ///< each update's minimum of all repeats
    std::vector<double> raw_ns;   ///< of every update of every repeat
    double touching = 0.0;        ///< share of updates in contact
};

/// Follows the path `kRepeats` times, each time with a new proxy and identical results. The step to
/// the first tip is not timed.
ProxyTimes time_proxy(const contact::HapticSurface &surface, const std::vector<Vector3> &tips_m) {
    ProxyTimes times;
    times.raw_ns.reserve(kRepeats * tips_m.size());
    std::size_t touching = 0;
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
        contact::Proxy proxy = proxy_at(surface, tips_m.front());
        for (const Vector3 &tip_m : tips_m) {
            contact::Contact contact;
            times.raw_ns.push_back(time_ns([&] {
                contact = proxy.update(surface, tip_m);
                benchmark::DoNotOptimize(contact);
            }));
            touching += contact.touching ? 1 : 0;
        }
    }
    times.touching = static_cast<double>(touching) / static_cast<double>(times.raw_ns.size());
    times.floor_ns = min_of_repeats(times.raw_ns);
    return times;
}

/// The same once, with 96 MB of other memory swept before each update, so that the surface is in no
/// cache [ns].
std::vector<double> time_proxy_cold(const contact::HapticSurface &surface,
                                    const std::vector<Vector3> &tips_m) {
    Sweep sweep;
    contact::Proxy proxy = proxy_at(surface, tips_m.front());
    std::vector<double> times_ns;
    times_ns.reserve(tips_m.size());
    for (const Vector3 &tip_m : tips_m) {
        sweep();
        times_ns.push_back(
            time_ns([&] { benchmark::DoNotOptimize(proxy.update(surface, tip_m)); }));
    }
    return times_ns;
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

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kFanRadius_m = 5e-3;
constexpr int kFanTicks = 3000;

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
constexpr std::uint32_t kFanTriangles[]{100, 1'000, 10'000, 50'000};

contact::TriangleSoup with_material(contact::TriangleSoup soup) {
    soup.material_of_triangle.assign(soup.triangles.size(), 0);
    soup.materials = {{"hard", 0.0}};
    return soup;
}

contact::TriangleSoup fan_of(std::uint32_t count, const FanShape &shape) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> one(-1.0, 1.0);
    contact::TriangleSoup soup;
    soup.vertices_m = {Vector3::Zero()};
    for (std::uint32_t i = 0; i < count; ++i) {
        const double phi = kTurn * i / count;
        const double out = 1.0 - shape.jagged * 0.5 * (1.0 + one(random));
        // The height does not follow the outline, so that a jagged rim makes a fan rough too,
        // unless it is flat.
        const double height =
            shape.slope + shape.wave * std::cos(2.0 * phi) + shape.rough * one(random);
        soup.vertices_m.emplace_back(kFanRadius_m *
                                     Vector3(out * std::cos(phi), height, out * std::sin(phi)));
        soup.triangles.push_back({0, 1 + (i + 1) % count, 1 + i});
    }
    return with_material(std::move(soup));
}

/// Pages about an edge, all around but for a tenth.
contact::TriangleSoup book_of(std::uint32_t count) {
    contact::TriangleSoup soup;
    soup.vertices_m = {{-kFanRadius_m, 0.0, 0.0}, {kFanRadius_m, 0.0, 0.0}};
    for (std::uint32_t i = 0; i < count; ++i) {
        const double phi = 0.9 * kTurn * i / count;
        soup.vertices_m.emplace_back(0.0, kFanRadius_m * std::cos(phi),
                                     kFanRadius_m * std::sin(phi));
        soup.triangles.push_back({0, 1, 2 + i});
    }
    return with_material(std::move(soup));
}

/// Down onto the surface, and around and across the vertex at 40 µm a tick.
std::vector<Vector3> tips_over_fan() {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> one(-1.0, 1.0);
    std::vector<Vector3> tips_m;
    for (int tick = 0; tick < kFanTicks; ++tick) {
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

void print_fan(const char *name, const contact::TriangleSoup &soup,
               const std::vector<Vector3> &tips_m) {
    contact::HapticSurface surface;
    const double preparation_ns = time_ns([&] { surface = contact::HapticSurface(soup); });
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
            if (repeat > 0) {
                continue;
            }
            touching += contact.touching ? 1 : 0;
            if (!contact.settled) {
                ++unsettled;
                largest_lag_m = std::max(largest_lag_m, lag_m(proxy, surface, tip_m, contact.x0_m));
            }
        }
    }
    const std::vector<double> floor_ns = min_of_repeats(times_ns);
    const auto at_us = [&](double share) { return 1e-3 * quantile(floor_ns, share); };
    std::printf("| %s | %zu | %.3f | %.1f | %.2f / %.1f / %.1f / %.1f | %d of %d | %.0f |\n", name,
                soup.triangles.size(), 1e-9 * preparation_ns,
                1e-6 * static_cast<double>(surface.bytes()), at_us(0.5), at_us(0.99), at_us(0.999),
                at_us(1.0), unsettled, touching, 1e6 * largest_lag_m);
}

void run_fans() {
    const std::vector<Vector3> tips_m = tips_over_fan();
    std::puts("| | triangles | preparation [s] | memory [MB] | update, floor: median / p99 / "
              "p99.9 / max [µs] | unsettled | lag of those [µm] |\n"
              "|:--|--:|--:|--:|:-:|--:|--:|");
    for (const FanShape &shape : kFans) {
        for (const std::uint32_t count : kFanTriangles) {
            print_fan(shape.name, fan_of(count, shape), tips_m);
        }
    }
    for (const std::uint32_t count : kFanTriangles) {
        print_fan("book", book_of(count), tips_m);
    }
}

} // namespace

int main(int argc, char **argv) {
    try {
        bool quick = false;
        bool fans = false;
        std::size_t only = 0;
        CLI::App app("What the proxy costs, as a Markdown table.", "proxy_benchmark");
        app.add_flag("--quick", quick, "fewer updates, and up to 81920 triangles only");
        std::vector<std::size_t> sizes(kTriangles.begin(), kTriangles.end());
        sizes.push_back(kHardTriangles);
        app.add_option("--only", only, "surfaces of that many triangles only")
            ->check(CLI::IsMember(sizes));
        app.add_flag("--fans", fans, "fans and books of triangles instead");
        CLI11_PARSE(app, argc, argv);
        fans ? run_fans() : run(quick, only);
    } catch (const std::exception &error) {
        std::fprintf(stderr, "proxy_benchmark: %s\n", error.what());
        return 1;
    }
    return 0;
}

#include "tests/bench/other_libraries.h"

#include "engine/contact/mesh/nearest.h"
#include "tests/bench/stopwatch.h"

#include <Eigen/Geometry>
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
#include <cmath>
#include <cstdint>
#include <memory>
#include <type_traits>

namespace springdrive::bench {

namespace {

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
bool consider_triangle(RTCPointQueryFunctionArguments *asked) {
    auto &nearest = *static_cast<Nearest *>(asked->userPtr);
    const auto &[a, b, c] = nearest.soup->triangles[asked->primID];
    const auto &vertices_m = nearest.soup->vertices_m;
    const contact::TrianglePoint found =
        contact::nearest_on_triangle({vertices_m[a], vertices_m[b], vertices_m[c]}, nearest.tip_m);
    const double distance_m = (found.point_m - nearest.tip_m).norm();
    if (distance_m >= nearest.distance_m) {
        return false;
    }
    nearest.distance_m = distance_m;
    asked->query->radius = static_cast<float>(distance_m);
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

} // namespace

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

} // namespace springdrive::bench

#include "engine/lab/charts/touch_trial.h"

#include "base/assertions.h"
#include "base/degrees.h"
#include "base/timing.h"
#include "engine/contact/proxy/proxy.h"
#include "engine/control/rendered_force.h"
#include "engine/lab/charts/charts.h"
#include "engine/lab/rig/scenario/known_shapes.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/scene/curved_patches.h"
#include "engine/scene/gltf_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::charts {

namespace {

constexpr std::size_t kMaxCuts = 128;

/// Vertices are not shared; mesh preparation welds them. Each division makes four triangles of one.
contact::TriangleSoup plate_mesh(int divisions) {
    contact::TriangleSoup soup =
        rig::solid_box(-rig::thin_plate_half_size_m(), rig::thin_plate_half_size_m());
    for (int i = 0; i < divisions; ++i) {
        const std::vector<Vector3> coarse = std::exchange(soup.vertices_m, {});
        for (std::size_t first = 0; first < coarse.size(); first += 3) {
            const Vector3 &a = coarse[first];
            const Vector3 &b = coarse[first + 1];
            const Vector3 &c = coarse[first + 2];
            const Vector3 ab = 0.5 * (a + b);
            const Vector3 bc = 0.5 * (b + c);
            const Vector3 ca = 0.5 * (c + a);
            soup.vertices_m.insert(soup.vertices_m.end(),
                                   {a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca});
        }
    }
    soup.triangles.clear();
    for (std::uint32_t first = 0; first < soup.vertices_m.size(); first += 3) {
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    soup.material_of_triangle.assign(soup.triangles.size(), 0);
    return soup;
}

contact::AnalyticShape about_origin(const contact::AnalyticShape::Size &size) {
    return {size, Eigen::Isometry3d::Identity(), 0};
}

/// Height above the surface at which the proxy starts [m].
constexpr double kStartHeight_m = 0.01;

/// The 99th percentile; 0 for an empty list.
double percentile_99(std::vector<double> values) {
    if (values.empty()) {
        return 0.0;
    }
    const double rank = std::ceil(0.99 * static_cast<double>(values.size()));
    const auto at = static_cast<std::ptrdiff_t>(rank) - 1;
    std::ranges::nth_element(values, values.begin() + at);
    return values[static_cast<std::size_t>(at)];
}

/// Twenty seconds of touch at 1 kHz.
constexpr std::size_t kTips = 20'000;

/// Finer meshes are flat enough to need no subdivision.
constexpr int kFinestBentDivisions = 6;

constexpr const char *kPenalty = "closest point (penalty)";
constexpr const char *kProxy = "proxy (god-object)";
constexpr const char *kBentProxy = "proxy, smooth shading";
constexpr const char *kPrimitive = "proxy, analytic primitive";

enum class Judged { depth, direction };

/// Runs one method over all tips and measures its time and its error.
template <typename Render>
ChartPoint trial_point(const ChartSetting &setting, const TouchTrial &trial, Judged judged,
                       const Render &render) {
    std::vector<RenderedTouch> touches(trial.tips.size());
    ChartPoint point;
    point.cost =
        cost_of(setting.repeats, static_cast<double>(trial.tips.size()), [&] { render(touches); });
    const TouchErrors errors = touch_errors(trial.tips, touches);
    point.error =
        judged == Judged::depth ? errors.depth_m : errors.direction_rad * kDegreesPerRadian;
    point.stable = !errors.pops_through;
    return point;
}

ChartPoint proxy_point(const ChartSetting &setting, const TouchTrial &trial, Judged judged,
                       const contact::HapticSurface &surface) {
    return trial_point(setting, trial, judged, [&](std::vector<RenderedTouch> &touches) {
        follow_with_proxy(surface, trial.tips, touches);
    });
}

ChartPoint penalty_point(const ChartSetting &setting, const TouchTrial &trial, Judged judged,
                         const contact::TriangleSoup &soup) {
    rig::ClosestPointFinder mesh(soup);
    return trial_point(setting, trial, judged, [&](std::vector<RenderedTouch> &touches) {
        push_to_closest_point(mesh, trial.tips, touches);
    });
}

contact::HapticSurface primitive_surface(const contact::AnalyticShape &shape) {
    contact::TriangleSoup material_only;
    material_only.materials = {{"primitive", 0.0}};
    return contact::HapticSurface(std::move(material_only), {shape});
}

ChartPoint named(ChartPoint point, const char *method, std::string setting) {
    point.method = method;
    point.setting = std::move(setting);
    return point;
}

/// A line for each method, from coarse to fine.
std::vector<ChartPoint> trial_points(const ChartSetting &setting, const TouchTrial &trial,
                                     Judged judged, const ChartProgress &progress) {
    std::vector<ChartPoint> penalty;
    std::vector<ChartPoint> proxy;
    std::vector<ChartPoint> bent_proxy;
    constexpr int kMeshes = kFinestDivisions + 1 - kCoarsestDivisions;
    for (int divisions = kCoarsestDivisions; divisions <= kFinestDivisions; ++divisions) {
        const contact::TriangleSoup soup = trial.mesh(divisions);
        const std::string size = std::to_string(soup.triangles.size()) + " triangles";
        penalty.push_back(named(penalty_point(setting, trial, judged, soup), kPenalty, size));
        proxy.push_back(
            named(proxy_point(setting, trial, judged, contact::HapticSurface(soup)), kProxy, size));
        if (trial.normal && divisions <= kFinestBentDivisions) {
            const contact::HapticSurface surface(bent(soup, trial.normal));
            bent_proxy.push_back(
                named(proxy_point(setting, trial, judged, surface), kBentProxy, size));
        }
        progress((divisions - kCoarsestDivisions + 1.0) / (kMeshes + 1.0));
    }
    std::vector<ChartPoint> points = std::move(penalty);
    points.insert(points.end(), proxy.begin(), proxy.end());
    points.insert(points.end(), bent_proxy.begin(), bent_proxy.end());
    if (trial.primitive) {
        points.push_back(
            named(proxy_point(setting, trial, judged, primitive_surface(*trial.primitive)),
                  kPrimitive, "exact"));
    }
    progress(1.0);
    return points;
}

SpeedAccuracyChart touch_chart(const char *name, TouchTrial (*made)(std::size_t tips),
                               Judged judged, const ChartSetting &setting,
                               const ChartProgress &progress) {
    const TouchTrial trial = made(kTips);
    return {name, "Methods of rendering " + trial.what, "processor time per update",
            judged == Judged::depth ? "error of the penetration depth, 99th percentile (m)"
                                    : "error of the force's direction, 99th percentile (degrees)",
            trial_points(setting, trial, judged, progress)};
}

} // namespace

TouchTrial sphere_trial(std::size_t tips) {
    return {"a sphere of 50 mm radius", rig::tips_in_sphere(tips),
            [](int divisions) { return rig::icosphere(divisions, rig::kTestSphereRadius_m); },
            [](const Vector3 &vertex_m) { return vertex_m.normalized(); },
            about_origin(contact::Sphere{rig::kTestSphereRadius_m})};
}

TouchTrial organic_trial(std::size_t tips) {
    return {"an organic shape of 100 mm", rig::tips_in_organic_shape(tips),
            [](int divisions) { return rig::organic_surface(divisions, rig::kTestOrganicScale_m); },
            [](const Vector3 &vertex_m) {
                return rig::organic_shape().outward_normal(vertex_m / rig::kTestOrganicScale_m);
            },
            std::nullopt};
}

TouchTrial thin_plate_trial(std::size_t tips) {
    return {"a plate of 2 mm", rig::tips_in_thin_plate(tips), plate_mesh, nullptr,
            about_origin(contact::Box{rig::thin_plate_half_size_m()})};
}

contact::TriangleSoup bent(const contact::TriangleSoup &soup,
                           const std::function<Vector3(const Vector3 &)> &normal) {
    scene::SmoothMesh mesh;
    mesh.positions = soup.vertices_m;
    mesh.triangles = soup.triangles;
    for (const Vector3 &vertex_m : soup.vertices_m) {
        mesh.normals.push_back(normal(vertex_m));
    }
    const scene::CurvedPatches patches(std::move(mesh));
    const auto maximum =
        static_cast<std::size_t>(std::sqrt(static_cast<double>(scene::gltf::kMaxCurvedTriangles) /
                                           static_cast<double>(soup.triangles.size())));
    const std::size_t cuts = patches.cuts_for(scene::gltf::kSmooth_deg * kRadiansPerDegree,
                                              std::clamp<std::size_t>(maximum, 1, kMaxCuts));
    scene::SmoothMesh curved = patches.cut(cuts, 0, soup.triangles.size());
    contact::TriangleSoup fine;
    fine.vertices_m = std::move(curved.positions);
    fine.triangles = std::move(curved.triangles);
    fine.material_of_triangle.assign(fine.triangles.size(), 0);
    fine.materials = soup.materials;
    return fine;
}

void follow_with_proxy(const contact::HapticSurface &surface, std::span<const rig::PressedTip> tips,
                       std::span<RenderedTouch> touches) {
    SPRINGDRIVE_ASSERT(!tips.empty() && touches.size() >= tips.size());
    contact::Proxy proxy;
    proxy.reset(tips.front().surface_m + kStartHeight_m * tips.front().normal);
    for (std::size_t i = 0; i < tips.size(); ++i) {
        const contact::Contact contact = proxy.update(surface, tips[i].tip_m);
        touches[i] = {};
        if (contact.touching) {
            touches[i] = {(contact.surface_m - tips[i].tip_m).norm(), contact.normal};
        }
    }
}

void push_to_closest_point(rig::ClosestPointFinder &mesh, std::span<const rig::PressedTip> tips,
                           std::span<RenderedTouch> touches) {
    SPRINGDRIVE_ASSERT(touches.size() >= tips.size());
    for (std::size_t i = 0; i < tips.size(); ++i) {
        const rig::ClosestPoint closest = mesh.closest(tips[i].tip_m);
        const Vector3 way_m = closest.point_m - tips[i].tip_m;
        touches[i] = {};
        if (way_m.dot(closest.normal) > 0.0) { // inside
            const double depth_m = way_m.norm();
            touches[i] = {depth_m, way_m / depth_m};
        }
    }
}

TouchErrors touch_errors(std::span<const rig::PressedTip> tips,
                         std::span<const RenderedTouch> touches) {
    SPRINGDRIVE_ASSERT(!tips.empty() && touches.size() >= tips.size());
    TouchErrors errors;
    std::vector<double> depth_m;
    std::vector<double> direction_rad;
    for (std::size_t i = 0; i < tips.size(); ++i) {
        depth_m.push_back(std::abs(touches[i].depth_m - tips[i].depth_m()));
        if (!touches[i].normal.isZero(0.0)) {
            direction_rad.push_back(
                control::direction_error_rad(touches[i].normal, tips[i].normal));
            errors.pops_through |= touches[i].normal.dot(tips[i].normal) < 0.0;
        }
    }
    errors.depth_m = percentile_99(std::move(depth_m));
    errors.direction_rad = percentile_99(std::move(direction_rad));
    return errors;
}

SpeedAccuracyChart sphere_depth_chart(const ChartSetting &setting, const ChartProgress &progress) {
    return touch_chart("proxies_sphere_depth", sphere_trial, Judged::depth, setting, progress);
}

SpeedAccuracyChart sphere_direction_chart(const ChartSetting &setting,
                                          const ChartProgress &progress) {
    return touch_chart("proxies_sphere_direction", sphere_trial, Judged::direction, setting,
                       progress);
}

SpeedAccuracyChart organic_depth_chart(const ChartSetting &setting, const ChartProgress &progress) {
    return touch_chart("proxies_organic_depth", organic_trial, Judged::depth, setting, progress);
}

SpeedAccuracyChart organic_direction_chart(const ChartSetting &setting,
                                           const ChartProgress &progress) {
    return touch_chart("proxies_organic_direction", organic_trial, Judged::direction, setting,
                       progress);
}

SpeedAccuracyChart thin_plate_chart(const ChartSetting &setting, const ChartProgress &progress) {
    return touch_chart("proxies_thin_plate", thin_plate_trial, Judged::depth, setting, progress);
}

} // namespace springdrive::charts

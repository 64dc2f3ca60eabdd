#include "engine/lab/charts/proxy_chart.h"

#include "base/degrees.h"
#include "base/timing.h"
#include "engine/lab/charts/rendered_touch.h"
#include "engine/lab/charts/touch_trial.h"

#include <string>
#include <utility>
#include <vector>

namespace springdrive::charts {

namespace {

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

SpeedAccuracyChart proxy_chart(std::string name, const ChartSetting &setting,
                               const TouchTrial &trial, Judged judged,
                               const ChartProgress &progress) {
    SpeedAccuracyChart chart;
    chart.name = std::move(name);
    chart.title = "Methods of rendering " + trial.what;
    chart.cost_label = "processor time per update";
    chart.error_label = judged == Judged::depth
                            ? "error of the penetration depth, 99th percentile (m)"
                            : "error of the force's direction, 99th percentile (degrees)";
    chart.points = trial_points(setting, trial, judged, progress);
    return chart;
}

} // namespace

SpeedAccuracyChart sphere_depth_chart(const ChartSetting &setting, const ChartProgress &progress) {
    return proxy_chart("proxies_sphere_depth", setting, sphere_trial(kTips), Judged::depth,
                       progress);
}

SpeedAccuracyChart sphere_direction_chart(const ChartSetting &setting,
                                          const ChartProgress &progress) {
    return proxy_chart("proxies_sphere_direction", setting, sphere_trial(kTips), Judged::direction,
                       progress);
}

SpeedAccuracyChart organic_depth_chart(const ChartSetting &setting, const ChartProgress &progress) {
    return proxy_chart("proxies_organic_depth", setting, organic_trial(kTips), Judged::depth,
                       progress);
}

SpeedAccuracyChart organic_direction_chart(const ChartSetting &setting,
                                           const ChartProgress &progress) {
    return proxy_chart("proxies_organic_direction", setting, organic_trial(kTips),
                       Judged::direction, progress);
}

SpeedAccuracyChart thin_plate_chart(const ChartSetting &setting, const ChartProgress &progress) {
    return proxy_chart("proxies_thin_plate", setting, thin_plate_trial(kTips), Judged::depth,
                       progress);
}

} // namespace springdrive::charts

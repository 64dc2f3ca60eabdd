#include "engine/analysis/work_precision/proxy_chart.h"

#include "engine/analysis/work_precision/rendered_touch.h"
#include "engine/analysis/work_precision/timing.h"
#include "engine/analysis/work_precision/touch_trial.h"

#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace springdrive {

namespace {

/// Twenty seconds of touch at 1 kHz.
constexpr std::size_t kTips = 20'000;

/// Finer meshes are flat enough not to be cut any further.
constexpr int kFinestBentDivisions = 6;

constexpr const char *kPenalty = "closest point (penalty)";
constexpr const char *kProxy = "proxy (god-object)";
constexpr const char *kBentProxy = "proxy, smooth shading";
constexpr const char *kPrimitive = "proxy, analytic primitive";

enum class Judged { depth, direction };

/// Runs one method over all tips, against the clock and against the truth.
template <typename Render>
WorkPoint trial_point(const ChartSetting &setting, const TouchTrial &trial, Judged judged,
                      const Render &render) {
    std::vector<RenderedTouch> touches(trial.tips.size());
    WorkPoint point;
    point.cost =
        cost_of(setting.repeats, static_cast<double>(trial.tips.size()), [&] { render(touches); });
    const TouchErrors errors = touch_errors(trial.tips, touches);
    point.error =
        judged == Judged::depth ? errors.depth_m : errors.direction_rad * 180.0 / std::numbers::pi;
    point.stable = !errors.pops_through;
    return point;
}

WorkPoint proxy_point(const ChartSetting &setting, const TouchTrial &trial, Judged judged,
                      const HapticSurface &surface) {
    return trial_point(setting, trial, judged, [&](std::vector<RenderedTouch> &touches) {
        follow_with_proxy(surface, trial.tips, touches);
    });
}

WorkPoint penalty_point(const ChartSetting &setting, const TouchTrial &trial, Judged judged,
                        const TriangleSoup &soup) {
    ClosestPointFinder mesh(soup);
    return trial_point(setting, trial, judged, [&](std::vector<RenderedTouch> &touches) {
        push_to_closest_point(mesh, trial.tips, touches);
    });
}

HapticSurface primitive_surface(const AnalyticShape &shape) {
    TriangleSoup material_only;
    material_only.materials = {{"primitive", 0.0}};
    return HapticSurface(std::move(material_only), {shape});
}

WorkPoint named(WorkPoint point, const char *method, std::string setting) {
    point.method = method;
    point.setting = std::move(setting);
    return point;
}

/// A line for each method, from coarse to fine.
std::vector<WorkPoint> trial_points(const ChartSetting &setting, const TouchTrial &trial,
                                    Judged judged, const ChartProgress &progress) {
    std::vector<WorkPoint> penalty;
    std::vector<WorkPoint> proxy;
    std::vector<WorkPoint> bent_proxy;
    constexpr int kMeshes = kFinestDivisions + 1 - kCoarsestDivisions;
    for (int divisions = kCoarsestDivisions; divisions <= kFinestDivisions; ++divisions) {
        const TriangleSoup soup = trial.mesh(divisions);
        const std::string size = std::to_string(soup.triangles.size()) + " triangles";
        penalty.push_back(named(penalty_point(setting, trial, judged, soup), kPenalty, size));
        proxy.push_back(
            named(proxy_point(setting, trial, judged, HapticSurface(soup)), kProxy, size));
        if (trial.normal && divisions <= kFinestBentDivisions) {
            const HapticSurface surface(bent(soup, trial.normal));
            bent_proxy.push_back(
                named(proxy_point(setting, trial, judged, surface), kBentProxy, size));
        }
        progress((divisions - kCoarsestDivisions + 1.0) / (kMeshes + 1.0));
    }
    std::vector<WorkPoint> points = std::move(penalty);
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

WorkPrecisionChart proxy_chart(std::string name, const ChartSetting &setting,
                               const TouchTrial &trial, Judged judged,
                               const ChartProgress &progress) {
    WorkPrecisionChart chart;
    chart.name = std::move(name);
    chart.title = "Ways to touch " + trial.what;
    chart.cost_label = "processor time per update";
    chart.error_label = judged == Judged::depth
                            ? "error of the penetration depth, 99th percentile (m)"
                            : "error of the force's direction, 99th percentile (degrees)";
    chart.points = trial_points(setting, trial, judged, progress);
    return chart;
}

} // namespace

WorkPrecisionChart sphere_depth_chart(const ChartSetting &setting, const ChartProgress &progress) {
    return proxy_chart("proxies_sphere_depth", setting, sphere_trial(kTips), Judged::depth,
                       progress);
}

WorkPrecisionChart sphere_direction_chart(const ChartSetting &setting,
                                          const ChartProgress &progress) {
    return proxy_chart("proxies_sphere_direction", setting, sphere_trial(kTips), Judged::direction,
                       progress);
}

WorkPrecisionChart organic_depth_chart(const ChartSetting &setting, const ChartProgress &progress) {
    return proxy_chart("proxies_organic_depth", setting, organic_trial(kTips), Judged::depth,
                       progress);
}

WorkPrecisionChart organic_direction_chart(const ChartSetting &setting,
                                           const ChartProgress &progress) {
    return proxy_chart("proxies_organic_direction", setting, organic_trial(kTips),
                       Judged::direction, progress);
}

WorkPrecisionChart thin_plate_chart(const ChartSetting &setting, const ChartProgress &progress) {
    return proxy_chart("proxies_thin_plate", setting, thin_plate_trial(kTips), Judged::depth,
                       progress);
}

} // namespace springdrive

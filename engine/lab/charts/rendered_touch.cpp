#include "engine/lab/charts/rendered_touch.h"

#include "base/assertions.h"
#include "engine/contact/proxy/proxy.h"
#include "engine/control/force_direction.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace springdrive::charts {

namespace {

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

} // namespace

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

} // namespace springdrive::charts

#include "engine/lab/rig/scenario/scenarios.h"

#include "base/cancellation.h"
#include "engine/scene/scripted_touch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

namespace springdrive::rig {

namespace {

constexpr double kTick_s = 0.005; // of the path's points
constexpr double kPi = std::numbers::pi;

/// The figure seen from above: frequency ratio 2 : 3, so that it crosses the middle in many
/// directions.
class Figure {
public:
    Figure(const Vector3 &middle_m, const Vector3 &half_m) : middle_m_(middle_m), half_m_(half_m) {}

    [[nodiscard]] Vector3 at(double phase) const {
        return middle_m_ + Vector3(half_m_.x() * std::sin(2.0 * phase), 0.0,
                                   half_m_.z() * std::sin(3.0 * phase));
    }

    /// The phase `way_m` farther along the path.
    [[nodiscard]] double after(double phase, double way_m) const {
        const double slope_m = std::hypot(2.0 * half_m_.x() * std::cos(2.0 * phase),
                                          3.0 * half_m_.z() * std::cos(3.0 * phase));
        const double min_m = 0.2 * std::max(half_m_.x(), half_m_.z()); // it reverses quickly
        return phase + way_m / std::max({slope_m, min_m, 1e-4});
    }

private:
    Vector3 middle_m_;
    Vector3 half_m_;
};

/// How high the surface is below (x, z) as seen from above; the floor where nothing is.
double height_m(const scene::SurfaceProbe &probe, const Vector3 &point_m) {
    const Eigen::AlignedBox3d &box = probe.box();
    constexpr double kRoom_m = 0.005;
    const Vector3 above_m(point_m.x(), box.max().y() + kRoom_m, point_m.z());
    const Vector3 below_m(point_m.x(), box.min().y(), point_m.z());
    const std::optional<Vector3> touched_m = probe.first_touch(above_m, below_m);
    return touched_m ? touched_m->y() : box.min().y();
}

/// Below the surface: down and up again, beginning with the touch.
double depth_m(const Exploration &how, double time_s) {
    const double middle_m = 0.5 * (how.min_depth_m + how.max_depth_m);
    const double half_m = 0.5 * (how.max_depth_m - how.min_depth_m);
    return middle_m + half_m * std::sin(2.0 * kPi * how.press_hz * time_s);
}

/// The points after the rest, for a figure of that size.
std::vector<simulated::HandPath::Point> points_of(const scene::SurfaceProbe &probe,
                                                  const Figure &figure, const Exploration &how) {
    std::vector<simulated::HandPath::Point> points;
    double phase = 0.0;
    double y_m = height_m(probe, figure.at(0.0));
    const double begin_s = how.rest_s + how.approach_s;
    const long count = std::lround(std::ceil((how.duration_s - begin_s) / kTick_s));
    for (long i = 0; i < count; ++i) {
        stop_if_given_up();
        const double since_s = static_cast<double>(i) * kTick_s;
        Vector3 point_m = figure.at(phase);
        const double max_m = how.climb_m_per_s * kTick_s;
        y_m = std::clamp(height_m(probe, point_m), y_m - max_m, y_m + max_m);
        point_m.y() = y_m - depth_m(how, since_s);
        points.push_back({begin_s + since_s, point_m});
        phase = figure.after(phase, how.speed_m_per_s * kTick_s);
    }
    return points;
}

bool reaches_all(const device::DeviceDescription &device,
                 const std::vector<simulated::HandPath::Point> &points) {
    return std::ranges::all_of(points, [&](const simulated::HandPath::Point &point) {
        return device::can_reach(device, point.position_m);
    });
}

} // namespace

simulated::HandPath exploration_path(const device::DeviceDescription &device,
                                     const contact::HapticSurface &surface,
                                     const Eigen::AlignedBox3d &box, const Vector3 &start_m,
                                     const Exploration &how) {
    const scene::SurfaceProbe probe(surface, box, 0.0);
    Vector3 middle_m = box.center();
    Vector3 half_m = 0.35 * box.sizes();
    if (how.planar) {
        middle_m.x() = start_m.x();
        half_m.x() = 0.0;
    }
    std::vector<simulated::HandPath::Point> path{{0.0, start_m}, {how.rest_s, start_m}};
    constexpr int kHalvings = 4;
    for (int halving = 0; halving <= kHalvings; ++halving) {
        const std::vector<simulated::HandPath::Point> points =
            points_of(probe, Figure(middle_m, half_m), how);
        if (reaches_all(device, points)) {
            path.insert(path.end(), points.begin(), points.end());
            break;
        }
        half_m *= 0.5;
    }
    return simulated::HandPath(std::move(path));
}

} // namespace springdrive::rig

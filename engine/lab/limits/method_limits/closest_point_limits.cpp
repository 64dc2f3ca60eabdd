#include "engine/lab/limits/method_limits/limit_trials.h"

#include "engine/lab/limits/method_limits/pressed_plate.h"
#include "engine/lab/rig/closest_point.h"

#include <memory>

namespace springdrive::limits {

namespace {

constexpr const char *kClosest = "closest point (penalty)";

/// A tip pressed more than half way through a plate is nearer to the plate's other side.
LimitTrial closest_point_in_a_plate() {
    const auto finder = std::make_shared<rig::ClosestPointFinder>(plate(kPlate_m));
    return {{kClosest, "pressed in deeper than", "mm", plate_text(), 1e3 * 0.5 * kPlate_m, {}, {}},
            1e3 * 1e-6,
            1e3 * kPlate_m,
            false,
            [=](double depth_mm) {
                return finder->closest(at_height(-1e-3 * depth_mm)).normal.y() > 0.5;
            }};
}

/// The same holds for a tip so fast that it is already there in the first tick that finds it
/// inside.
LimitTrial closest_point_of_a_fast_tip() {
    constexpr int kPhases = 64;
    const auto finder = std::make_shared<rig::ClosestPointFinder>(plate(kPlate_m));
    const auto is_thrown_back = [finder](double start_m, double step_m) {
        double y_m = start_m;
        while (y_m > -2.0 * kHalfPlate_m) {
            const Vector3 tip_m = at_height(y_m);
            const rig::ClosestPoint found = finder->closest(tip_m);
            if (found.normal.dot(tip_m - found.point_m) < 0.0) {
                return found.normal.y() > 0.5;
            }
            y_m -= step_m;
        }
        return false;
    };
    return {{kClosest,
             "tip faster than",
             "m/s",
             plate_text() + ", 1 kHz: expelled on the far side, at the worst phase of a tick",
             0.5 * kPlate_m / kTickPeriod_s,
             {},
             {}},
            0.1,
            100.0,
            false,
            [=](double speed_m_per_s) {
                const double step_m = speed_m_per_s * kTickPeriod_s;
                for (int i = 0; i < kPhases; ++i) {
                    if (!is_thrown_back(1e-9 + step_m * i / kPhases, step_m)) {
                        return false;
                    }
                }
                return true;
            }};
}

/// Near the rim of a face the next face is nearer than the pressed one.
LimitTrial closest_point_near_an_edge() {
    constexpr double kDepth_m = 2e-3;
    const auto finder = std::make_shared<rig::ClosestPointFinder>(plate(kHalfPlate_m));
    return {{kClosest,
             "nearer to a convex edge than",
             "mm",
             "pressed in by " + with_unit(1e3 * kDepth_m, "mm") + ": the force turns by 90°",
             1e3 * kDepth_m,
             {},
             {}},
            1e3 * kHalfPlate_m / 2.0,
            1e-3,
            false,
            [=](double distance_mm) {
                const Vector3 tip_m(kHalfPlate_m - 1e-3 * distance_mm, -kDepth_m, kAside_m.z());
                return finder->closest(tip_m).normal.y() > 0.5;
            }};
}

} // namespace

std::vector<LimitTrial> closest_point_trials() {
    return {closest_point_in_a_plate(), closest_point_of_a_fast_tip(),
            closest_point_near_an_edge()};
}

} // namespace springdrive::limits

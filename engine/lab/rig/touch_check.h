// Holds what a proxy did against what it should have done, by means that share nothing with it.
#pragma once

#include "engine/contact/proxy/analytic_shape.h"
#include "engine/lab/rig/brute_force_proxy.h"
#include "engine/lab/rig/plain_triangles.h"
#include "engine/lab/rig/touch_run.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace springdrive::rig {

/// A proxy farther than this from where it could be lags [m].
inline constexpr double kLag_m = 1e-6;

/// Tips nearer to the proxy than this tell too little of a direction [m].
inline constexpr double kMinGap_m = 1e-5;

struct TouchCheckOptions {
    std::size_t checks = 200;          ///< steps in contact to check, spread over all of them
    std::size_t max_suspicious = 1000; ///< steps to check beside these, of each kind of suspicion
    double reach_m = 0.0;              ///< what the proxy keeps from every surface
    double slack_m = kMinSlack_m;      ///< see Downhill: lower ridges do not excuse a lag
};

/// The greatest of something, and the step it was found at.
struct Maximum {
    double value = 0.0;
    std::optional<std::size_t> step;

    void consider(double other, std::size_t at) {
        if (!step || other > value) {
            value = other;
            step = at;
        }
    }
};

/// What was touched, as the check sees it.
struct TouchedSurface {
    std::vector<PlainTriangle> triangles;
    std::vector<contact::AnalyticShape> shapes;
};

struct TouchFindings {
    std::vector<std::size_t> pop_throughs; ///< steps whose way goes through a triangle
    std::vector<std::size_t> stuck;        ///< that looked stuck, and lag
    std::vector<std::size_t> lagging;      ///< of those checked, the ones that lag
    std::vector<std::size_t> unsettled;    ///< flagged as unfinished by the proxy
    std::size_t checked = 0;
    std::size_t suspicious = 0;           ///< looked stuck
    std::size_t suspicious_unchecked = 0; ///< of these, beyond the cap
    std::size_t given_up = 0;             ///< checks that reached their step limit
    std::size_t with_friction = 0;        ///< in contact with friction, never checked for lag
    Maximum lag_m;                        ///< of steps flagged as settled
    Maximum unsettled_lag_m;              ///< of the others
    Maximum direction_error_rad;
};

/// Whether a step looks stuck: in contact as the step before, the tip moved on along the surface,
/// and the proxy by less than 1 % of that. A proxy in a corner does so correctly.
[[nodiscard]] bool looks_stuck(const TouchStep &before, const TouchStep &step);

/// Every step's path is checked against all triangles, but not against shapes. Of those in contact
/// without friction, some are checked for lag, how far down the distance to the tip one can still
/// get from where the proxy is, and for the angle between the contact's normal and that from the
/// tip to where one gets. Beside these, those that look stuck, those that did not settle, and those
/// that are free but not at the tip.
[[nodiscard]] TouchFindings check_touch(const TouchRun &run, const TouchedSurface &surface,
                                        const TouchCheckOptions &options);

/// The greatest angle between the contact's normal and the true one of a sphere about the origin,
/// over all steps in contact whose tip is deep enough and off the sphere's centre [rad].
[[nodiscard]] Maximum sphere_direction_error_rad(const TouchRun &run);

} // namespace springdrive::rig

// Holds what a proxy did against what it should have done, by means that share nothing with it.
#pragma once

#include "engine/contact/proxy/analytic_shape.h"
#include "engine/lab/rig/brute_force_proxy.h"
#include "engine/lab/rig/plain_triangles.h"
#include "engine/lab/rig/touch_run.h"

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

namespace springdrive::rig {

/// A proxy farther than this from where it could be lags [m].
inline constexpr double kLag_m = 1e-6;

/// Tips nearer to the proxy than this tell too little of a direction [m].
inline constexpr double kMinGap_m = 1e-5;

/// A rate of lagging steps that the default number of checks detects, and how surely.
inline constexpr double kDetectedRate = 1e-4;
inline constexpr double kConfidence = 0.95;

/// 29,956.
[[nodiscard]] std::size_t default_checks();

inline constexpr std::size_t kAllSteps = std::numeric_limits<std::size_t>::max();

struct TouchCheckOptions {
    /// Steps in contact to check, spread evenly over all of them; kAllSteps for every one.
    std::size_t checks = default_checks();
    /// Steps to check beside these, of each kind of suspicion.
    std::size_t max_suspicious = default_checks();
    double reach_m = 0.0;         ///< what the proxy keeps from every surface
    double slack_m = kMinSlack_m; ///< see Downhill: lower ridges do not excuse a lag
    /// Called with the share that is done, from the calling thread.
    std::function<void(double)> progress = [](double) {};
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

/// Consecutive steps in which the proxy stood still while the tip moved along the surface.
struct Stall {
    std::size_t steps = 0;
    std::size_t first = 0; ///< of them

    [[nodiscard]] std::size_t end() const { return first + steps; }
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
    std::size_t checked = 0;               ///< all that were
    std::size_t in_contact = 0;            ///< without friction
    std::size_t sampled = 0;               ///< of these, checked whatever they looked like
    std::size_t sampled_lagging = 0;
    std::size_t suspicious = 0;           ///< looked stuck
    std::size_t suspicious_unchecked = 0; ///< of these, beyond the cap
    std::size_t given_up = 0;             ///< checks that reached their step limit
    std::size_t with_friction = 0;        ///< in contact with friction, never checked for lag
    Maximum lag_m;                        ///< of steps flagged as settled
    Maximum unsettled_lag_m;              ///< of the others
    Maximum direction_error_rad;
    std::vector<std::optional<double>> lag_of_step_m; ///< of those checked
    Stall stall;     ///< the longest, right or wrong: at a corner it may be right
    Stall stuck_for; ///< the longest of steps that lag

    /// The rate of lagging steps that the sample does not exclude, with kConfidence.
    [[nodiscard]] double rate_not_excluded() const;
};

/// Whether a step looks stuck: in contact as the step before, the tip moved on along the surface,
/// and the proxy by less than 1 % of that. A proxy in a corner does so correctly.
[[nodiscard]] bool looks_stuck(const TouchStep &before, const TouchStep &step);

/// Every step's path is checked against all triangles, but not against shapes. Of those in contact
/// without friction, some are checked for lag: how far down the distance to the tip the proxy could
/// still get from where it is. The same steps are checked for the angle between the contact's
/// normal and that from the tip to where it could get. Beside these, those that look stuck, those
/// that did not settle, and those that are free but not at the tip.
/// Uses all processors; the result does not depend on their number.
[[nodiscard]] TouchFindings check_touch(const TouchRun &run, const TouchedSurface &surface,
                                        const TouchCheckOptions &options);

/// The greatest angle between the contact's normal and the true one of a sphere about the origin,
/// over all steps in contact whose tip is deep enough and off the sphere's centre [rad].
[[nodiscard]] Maximum sphere_direction_error_rad(const TouchRun &run);

} // namespace springdrive::rig

// A proxy's answers along a path of the tip with their times, and what they should have been, by
// means that share nothing with it.
#pragma once

#include "base/degrees.h"
#include "base/vector.h"
#include "engine/contact/proxy/analytic_shape.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/rig/brute_force_proxy.h"

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace springdrive::rig {

/// One update of the proxy.
struct TouchStep {
    Vector3 tip_m{Vector3::Zero()};
    Vector3 proxy_m{Vector3::Zero()};
    Vector3 normal{Vector3::Zero()}; ///< of the contact; zero when free
    int constraints = 0;             ///< 0 free, 1 face, 2 edge, 3 vertex
    bool settled = true;
    bool has_friction = false; ///< of the touched material: the proxy may lag
    double first_ns = 0.0;     ///< time of the first run
    double min_ns = 0.0;       ///< least time of all runs: without disturbance by other processes

    [[nodiscard]] bool is_touching() const { return constraints > 0; }
};

struct TouchRun {
    std::vector<TouchStep> steps;
    std::vector<Vector3> corners_m;        ///< of the proxy's paths, one step after another
    std::vector<std::size_t> first_corner; ///< of each step's path; one more for the end

    /// The path of a step, from the proxy's last position to its new one.
    [[nodiscard]] std::span<const Vector3> way(std::size_t step) const {
        return {corners_m.data() + first_corner[step], corners_m.data() + first_corner[step + 1]};
    }

    /// Adds a step and its path.
    void add(const TouchStep &step, std::span<const Vector3> way_m);
};

/// Lets a proxy follow the tip, from the first of `tips_m` on, where it starts free; repeated
/// for timing. Times include those of reading the clock, some 20 ns.
/// @pre there is at least one tip, and `repeats` >= 1
[[nodiscard]] TouchRun run_touch(const contact::HapticSurface &surface,
                                 std::span<const Vector3> tips_m, double radius_m, int repeats);

/// Quantiles of times, by rank.
struct UpdateTimes {
    double median_ns = 0.0;
    double p99_ns = 0.0;
    double p99_9_ns = 0.0;
    double max_ns = 0.0;
};

/// Of the steps that touch, or of those that do not. Nothing if there are none.
[[nodiscard]] std::optional<UpdateTimes> update_times(const TouchRun &run, bool touching,
                                                      double TouchStep::*time_ns);

/// The trials, without any failure, after which a rate of failures is excluded:
/// (1 − rate)ⁿ <= 1 − confidence, about 3 / rate at 95 %.
/// @pre both lie between 0 and 1
[[nodiscard]] std::size_t trials_to_exclude(double rate, double confidence);

/// The rate that is not excluded: with a greater one, as few failures as these would be found with
/// a probability of at most 1 − confidence. The upper limit of Clopper and Pearson (1934).
/// @pre failures <= trials; confidence between 0 and 1
[[nodiscard]] double rate_not_excluded(std::size_t failures, std::size_t trials, double confidence);

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
    /// Steps to check beside these, of each kind of suspicion; and the places at which the proxy
    /// stood, to check for holds.
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

/// A force this far from where a hop leads is wrong [rad].
inline constexpr double kHoldError_rad = 10.0 * kRadiansPerDegree;

/// A place that held a settled proxy for three steps or more, although in each of them a hop led
/// on to where the force has another direction, by more than kHoldError_rad: see
/// BruteForceProxy::hop.
struct Hold {
    Stall steps;
    Vector3 place_m{Vector3::Zero()}; ///< of the proxy, in the first
    double max_error_rad = 0.0;       ///< half a turn where the tip is free
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
    Stall stall;            ///< the longest, right or wrong: at a corner it may be right
    Stall stuck_for;        ///< the longest of steps that lag
    std::size_t stands = 0; ///< places at which it stood for three steps or more
    std::size_t stands_unchecked = 0;
    std::vector<Hold> holds; ///< in ascending order of their steps

    /// The rate of lagging steps that the sample does not exclude, with kConfidence.
    [[nodiscard]] double rate_not_excluded() const;
};

/// Whether a step looks stuck: in contact as the step before, the tip moved on along the surface,
/// and the proxy by less than 1 % of that. A proxy in a corner does so correctly.
[[nodiscard]] bool looks_stuck(const TouchStep &before, const TouchStep &step);

/// Runs of three steps or more, settled at an edge or vertex without friction, after the first of
/// which the proxy moves by no more than a hop in a step. On a face the tip's foot is right, also
/// beside a rim, and a lag says where it is not.
[[nodiscard]] std::vector<Stall> stands(const TouchRun &run);

/// Every step's path is checked against all triangles, but not against shapes. Of those in contact
/// without friction, some are checked for lag: how far down the distance to the tip the proxy could
/// still get from where it is. The same steps are checked for the angle between the contact's
/// normal and that from the tip to where it could get. Beside these, those that look stuck, those
/// that did not settle, and those that are free but not at the tip. Where the proxy stands, hops
/// are tried.
/// Uses all processors; the result does not depend on their number.
[[nodiscard]] TouchFindings check_touch(const TouchRun &run, const TouchedSurface &surface,
                                        const TouchCheckOptions &options);

/// The greatest angle between the contact's normal and the true one of a sphere about the origin,
/// over all steps in contact whose tip is deep enough and off the sphere's centre [rad].
[[nodiscard]] Maximum sphere_direction_error_rad(const TouchRun &run);

} // namespace springdrive::rig

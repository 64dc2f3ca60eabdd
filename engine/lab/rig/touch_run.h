// The proxy's result for each step of a path of the tip, and its time.
#pragma once

#include "base/vector.h"
#include "engine/contact/proxy/haptic_surface.h"

#include <cstddef>
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

} // namespace springdrive::rig

#include "engine/lab/limits/stability_map.h"

#include "base/parallel.h"
#include "device/core/phantom/kinematics.h"

#include <algorithm>
#include <mutex>

namespace springdrive::limits {

namespace {

/// All members with one motor at a time; only the worst with the whole linkage, which takes fifty
/// times as long.
std::size_t tried(const loops::StabilityCase &which, std::size_t all) {
    constexpr std::size_t kOfLinkage = 2;
    return which.freedom == loops::Freedom::one_motor ? all : std::min(all, kOfLinkage);
}

/// The largest ratio of tip speed to rotor speed.
double lever_m(const loops::StabilityCase &which, const loops::LoopMember &member) {
    const Matrix3 J = device::motor_jacobian(which.device.geometry, which.q_rad);
    return which.freedom == loops::Freedom::one_motor ? J.col(member.motor).norm()
                                                      : J.colwise().norm().maxCoeff();
}

void fill(MapCell &cell, const loops::StabilityCase &there) {
    const std::vector<loops::WorstMember> ranked = loops::ranked_members(there);
    cell.eigenvalue = ranked.front().eigenvalue;
    TrialOptions options = TrialOptions::with(SimulationEffects::electronics());
    options.longest_s = 1.0;
    options.extension_s = 0.0;
    for (std::size_t i = 0; i < tried(there, ranked.size()) && cell.stable; ++i) {
        const Trial trial = simulated(there, ranked[i].member, options);
        cell.stable = trial.stable;
        cell.remaining_m_per_s = std::max(
            cell.remaining_m_per_s, trial.last_rate_rad_per_s * lever_m(there, ranked[i].member));
    }
}

} // namespace

std::vector<MapCell> stability_map(const loops::StabilityCase &which, const MapAxis &x,
                                   const MapAxis &y, const std::function<void(double)> &progress) {
    std::vector<MapCell> cells;
    for (const double at_y : y.values()) {
        for (const double at_x : x.values()) {
            cells.push_back({at_x, at_y, 0.0, true, 0.0});
        }
    }
    std::mutex progress_mutex;
    std::size_t done = 0;
    for_each_in_parallel(cells.size(), all_processors(), [&](std::size_t i) {
        loops::StabilityCase there = which;
        x.parameter->set(there, cells[i].x);
        y.parameter->set(there, cells[i].y);
        fill(cells[i], there);
        const std::lock_guard lock(progress_mutex);
        progress(static_cast<double>(++done) / static_cast<double>(cells.size()));
    });
    return cells;
}

} // namespace springdrive::limits

#include "device/simulated/joint_stops.h"

#include <algorithm>
#include <array>

namespace springdrive::simulated {

namespace {

/// A firm rubber stop: 1 mrad at 0.1 N·m. Assumed; no data sheet states it.
constexpr double kStiffness_Nm_per_rad = 100.0;
constexpr double kDamping_Nms_per_rad = 0.1;

/// One stop: it presses where direction · q exceeds `angle_rad`.
struct Stop {
    Vector3 direction;
    double angle_rad;

    [[nodiscard]] double depth(const Vector3 &q_rad) const {
        return std::max(0.0, direction.dot(q_rad) - angle_rad);
    }
};

std::array<Stop, 8> stops(const device::JointLimits &limits) {
    const Vector3 fold(0.0, -1.0, 1.0);
    std::array<Stop, 8> all{};
    for (Eigen::Index j = 0; j < 3; ++j) {
        const auto index = static_cast<std::size_t>(2 * j);
        all[index] = {Vector3::Unit(j), limits.max_rad[j]};
        all[index + 1] = {-Vector3::Unit(j), -limits.min_rad[j]};
    }
    all[6] = {fold, limits.max_q3_minus_q2_rad};
    all[7] = {-fold, -limits.min_q3_minus_q2_rad};
    return all;
}

} // namespace

StopTorque stop_torque(const device::JointLimits &limits, const Vector3 &q_a_rad,
                       const Vector3 &q_b_rad) noexcept {
    StopTorque sum;
    if (limits.allow(q_a_rad) && limits.allow(q_b_rad)) {
        return sum; // the usual case
    }
    for (const Stop &stop : stops(limits)) {
        const double before = stop.depth(q_a_rad);
        const double after = stop.depth(q_b_rad);
        if (before == 0.0 && after == 0.0) {
            continue;
        }
        // ½k(after² − before²) over the distance, of which all or a part lies in the stop.
        const double distance = stop.direction.dot(q_b_rad - q_a_rad);
        const double share = before > 0.0 && after > 0.0 ? 1.0 : (after - before) / distance;
        sum.torque_Nm -= kStiffness_Nm_per_rad * 0.5 * (before + after) * share * stop.direction;
        if (before > 0.0) {
            sum.damping_Nms_per_rad +=
                kDamping_Nms_per_rad * stop.direction * stop.direction.transpose();
        }
    }
    return sum;
}

double stop_energy_J(const device::JointLimits &limits, const Vector3 &q_rad) noexcept {
    double energy = 0.0;
    for (const Stop &stop : stops(limits)) {
        const double depth = stop.depth(q_rad);
        energy += 0.5 * kStiffness_Nm_per_rad * depth * depth;
    }
    return energy;
}

} // namespace springdrive::simulated

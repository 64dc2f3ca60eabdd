#include "device/simulated/linkage_step.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

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

// With two joints that move, the base is at rest and the tip moves in the links' plane: outward and
// up.

/// Torques on the joints, affine in their mean rates: τ − B q̄̇.
template <int joints> struct LinkageForces {
    device::JointMatrix<joints> tip_m_per_rad;       ///< J̄
    device::JointMatrix<joints> damping_Nms_per_rad; ///< B, positive semidefinite
    device::JointVector<joints> torque_Nm;
};

/// A vector at the tip, projected to the coordinates in which the tip can move. RT-safe.
template <int joints>
[[nodiscard]] device::JointVector<joints> where_tip_moves(const LinkagePlant &plant,
                                                          const Vector3 &v) {
    if constexpr (joints == 3) {
        return v;
    } else {
        return {plant.outward.dot(v), v.y()};
    }
}

/// The inverse: back to three dimensions. RT-safe.
template <int joints>
[[nodiscard]] Vector3 in_space(const LinkagePlant &plant, const device::JointVector<joints> &v) {
    if constexpr (joints == 3) {
        return v;
    } else {
        return v[0] * plant.outward + v[1] * Vector3::UnitY();
    }
}

/// RT-safe.
template <int joints>
[[nodiscard]] LinkageForces<joints> linkage_forces(const LinkagePlant &plant,
                                                   const LinkageLoad &load,
                                                   const device::LinkageSecants<joints> &secants,
                                                   const Vector3 &q_a, const Vector3 &q_b) {
    LinkageForces<joints> sum;
    sum.tip_m_per_rad = secants.tip(plant.geometry);
    const device::JointMatrix<joints> &J = sum.tip_m_per_rad;
    sum.damping_Nms_per_rad = load.tip_damping_Ns_per_m * (J.transpose() * J);
    sum.damping_Nms_per_rad.diagonal() += load.damping_Nms_per_rad.template tail<joints>();
    sum.torque_Nm = load.torque_Nm.template tail<joints>() +
                    J.transpose() * where_tip_moves<joints>(plant, load.tip_force_N);
    if (plant.gravity) {
        sum.torque_Nm -= secants.gravity_Nm(plant.moments);
    }
    if (plant.stops) {
        const StopTorque pressed = stop_torque(plant.limits, q_a, q_b);
        sum.torque_Nm += pressed.torque_Nm.template tail<joints>();
        sum.damping_Nms_per_rad +=
            pressed.damping_Nms_per_rad.template bottomRightCorner<joints, joints>();
    }
    return sum;
}

/// Iterations end when the angles at the end of the step change by no more than this: round-off.
constexpr double kSettled_rad = 2e-16;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr int kMaxIterations = 12;
/// A step that does not converge is halved, repeatedly. No hand moves a device that fast.
constexpr int kMaxPieces = 64;

template <int joints>
device::JointMatrix<joints> inertia_with_rotors(const LinkagePlant &plant,
                                                const device::LinkSines &links) {
    device::JointMatrix<joints> M;
    if constexpr (joints == 3) {
        M = device::mass_matrix(plant.moments, links);
    } else {
        M = device::mass_matrix_of_plane(plant.moments, links);
    }
    M.diagonal() += plant.rotor_kg_m2.tail<joints>();
    return M;
}

/// All three joints; those that do not move have the value 0.
template <int joints> Vector3 all_joints(const device::JointVector<joints> &moving) {
    Vector3 all = Vector3::Zero();
    all.tail<joints>() = moving;
    return all;
}

/// Whether the end of the step no longer changes between iterations.
template <int joints>
bool settled(const Vector3 &q_a, const device::JointVector<joints> &rate,
             const device::JointVector<joints> &before, double h) {
    const double moved_rad = h * (rate - before).cwiseAbs().maxCoeff();
    return moved_rad <= std::max(kSettled_rad, kEpsilon * q_a.cwiseAbs().maxCoeff());
}

/// Solves a step with friction; without friction it is a plain system of equations.
template <int joints> class StepFriction {
public:
    StepFriction(const LinkagePlant &plant, const device::JointVector<joints> &rate_a, double h,
                 std::array<FrictionMode, 3> &modes)
        : has_friction_((plant.coulomb_Nm.array() > 0.0).any()), modes_(modes) {
        if (has_friction_) {
            range_ = JointFrictionRange<joints>::after(rate_a, plant.coulomb_Nm.tail<joints>());
            range_.minimum *= h;
            range_.maximum *= h;
        }
    }

    [[nodiscard]] device::JointVector<joints> solve(const device::JointMatrix<joints> &system,
                                                    const device::JointVector<joints> &right) {
        if (!has_friction_) {
            return solve_definite<joints>(system, right);
        }
        std::array<FrictionMode, static_cast<std::size_t>(joints)> modes{};
        std::copy_n(modes_.end() - joints, joints, modes.begin());
        const device::JointVector<joints> rate_b =
            solve_with_friction(system, right, range_, modes);
        std::copy_n(modes.begin(), joints, modes_.end() - joints);
        return rate_b;
    }

private:
    bool has_friction_;
    JointFrictionRange<joints> range_;
    std::array<FrictionMode, 3> &modes_;
};

template <int joints>
LinkageMotion motion_of(const LinkagePlant &plant, const Vector3 &q_a,
                        const device::JointVector<joints> &mean_rate,
                        const device::JointVector<joints> &rate_b,
                        const device::JointMatrix<joints> &tip_m_per_rad, double h) {
    LinkageMotion motion;
    motion.mean_rate_rad_per_s = all_joints<joints>(mean_rate);
    motion.after = {q_a + h * motion.mean_rate_rad_per_s, all_joints<joints>(rate_b)};
    motion.mean_tip_velocity_m_per_s = in_space<joints>(plant, tip_m_per_rad * mean_rate);
    return motion;
}

/// One solution of the equations in the header. Empty if the iterations do not converge.
template <int joints>
std::optional<LinkageMotion> accelerated_step(const LinkagePlant &plant, const LinkageState &before,
                                              const LinkageLoad &load, double h,
                                              std::array<FrictionMode, 3> &modes) {
    const Vector3 &q_a = before.q_rad;
    const device::JointVector<joints> rate_a = before.rate_rad_per_s.tail<joints>();
    const device::JointVector<joints> momentum_a =
        inertia_with_rotors<joints>(plant, device::LinkSines::of(q_a)) * rate_a;
    StepFriction<joints> friction(plant, rate_a, h, modes);

    device::JointVector<joints> mean_rate = rate_a;
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
        const Vector3 q_b = q_a + h * all_joints<joints>(mean_rate);
        const device::LinkageSecants<joints> secants(q_a, q_b);
        const LinkageForces<joints> force = linkage_forces<joints>(plant, load, secants, q_a, q_b);
        const device::JointMatrix<joints> &damping = force.damping_Nms_per_rad;
        const device::JointMatrix<joints> system =
            inertia_with_rotors<joints>(plant, secants.end()) + 0.5 * h * damping -
            h * secants.inertia(plant.moments, rate_a);
        const device::JointVector<joints> right =
            momentum_a + h * force.torque_Nm - 0.5 * h * (damping * rate_a);
        const device::JointVector<joints> rate_b = friction.solve(system, right);
        const device::JointVector<joints> guess = mean_rate;
        mean_rate = 0.5 * (rate_a + rate_b);
        if (settled<joints>(q_a, mean_rate, guess, h)) {
            return motion_of<joints>(plant, q_a, mean_rate, rate_b, force.tip_m_per_rad, h);
        }
    }
    return std::nullopt;
}

/// The same without masses.
template <int joints>
std::optional<LinkageMotion> balanced_step(const LinkagePlant &plant, const LinkageState &before,
                                           const LinkageLoad &load, double h) {
    const Vector3 &q_a = before.q_rad;
    device::JointVector<joints> mean_rate = before.rate_rad_per_s.tail<joints>();
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
        const Vector3 q_b = q_a + h * all_joints<joints>(mean_rate);
        const device::LinkageSecants<joints> secants(q_a, q_b);
        const LinkageForces<joints> force = linkage_forces<joints>(plant, load, secants, q_a, q_b);
        const device::JointVector<joints> guess = mean_rate;
        mean_rate = solve_definite<joints>(force.damping_Nms_per_rad, force.torque_Nm);
        if (settled<joints>(q_a, mean_rate, guess, h)) {
            return motion_of<joints>(plant, q_a, mean_rate, mean_rate, force.tip_m_per_rad, h);
        }
    }
    return std::nullopt;
}

std::optional<LinkageMotion> undivided_step(const LinkagePlant &plant, const LinkageState &before,
                                            const LinkageLoad &load, double h,
                                            std::array<FrictionMode, 3> &modes) {
    if (plant.has_mass) {
        return plant.planar ? accelerated_step<2>(plant, before, load, h, modes)
                            : accelerated_step<3>(plant, before, load, h, modes);
    }
    return plant.planar ? balanced_step<2>(plant, before, load, h)
                        : balanced_step<3>(plant, before, load, h);
}

/// The same in `pieces` equal sub-steps.
std::optional<LinkageMotion> divided_step(const LinkagePlant &plant, const LinkageState &before,
                                          const LinkageLoad &load, double step_s, int pieces,
                                          std::array<FrictionMode, 3> &modes) {
    LinkageMotion whole;
    whole.after = before;
    for (int piece = 0; piece < pieces; ++piece) {
        const std::optional<LinkageMotion> part =
            undivided_step(plant, whole.after, load, step_s / pieces, modes);
        if (!part) {
            return std::nullopt;
        }
        whole.after = part->after;
        whole.mean_rate_rad_per_s += part->mean_rate_rad_per_s / pieces;
        whole.mean_tip_velocity_m_per_s += part->mean_tip_velocity_m_per_s / pieces;
    }
    return whole;
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

double LinkagePlant::kinetic_energy_J(const LinkageState &state) const {
    if (!has_mass) {
        return 0.0;
    }
    return 0.5 * state.rate_rad_per_s.dot(
                     inertia_with_rotors<3>(*this, device::LinkSines::of(state.q_rad)) *
                     state.rate_rad_per_s);
}

double LinkagePlant::potential_energy_J(const LinkageState &state) const {
    return (gravity ? device::gravity_energy_J(moments, state.q_rad) : 0.0) +
           (stops ? stop_energy_J(limits, state.q_rad) : 0.0);
}

LinkageMotion linkage_step(const LinkagePlant &plant, const LinkageState &before,
                           const LinkageLoad &load, double step_s,
                           std::array<FrictionMode, 3> &modes) noexcept {
    std::optional<LinkageMotion> motion = undivided_step(plant, before, load, step_s, modes);
    for (int pieces = 2; !motion && pieces <= kMaxPieces; pieces *= 2) {
        motion = divided_step(plant, before, load, step_s, pieces, modes);
    }
    if (motion) {
        return *motion;
    }
    LinkageMotion stopped; // far outside the model's range: bring it to rest
    stopped.after.q_rad = before.q_rad;
    return stopped;
}

} // namespace springdrive::simulated

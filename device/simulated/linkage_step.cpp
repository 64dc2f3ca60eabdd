#include "device/simulated/linkage_step.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace springdrive {

namespace {

/// Iterations end when the angles at the end of the step move by no more than this: round-off.
constexpr double kSettled_rad = 2e-16;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr int kMostIterations = 12;
/// A step that does not settle is taken in halves, and those again. No hand moves a device so fast.
constexpr int kMostPieces = 64;

Matrix3 inertia_with_rotors(const LinkagePlant &plant, const Vector3 &q_rad) {
    Matrix3 M = mass_matrix(plant.moments, q_rad);
    M.diagonal() += plant.rotor_kg_m2;
    return M;
}

} // namespace

double LinkagePlant::kinetic_energy_J(const LinkageState &state) const {
    return 0.5 *
           state.rate_rad_per_s.dot(inertia_with_rotors(*this, state.q_rad) * state.rate_rad_per_s);
}

double LinkagePlant::potential_energy_J(const LinkageState &state) const {
    return (gravity ? gravity_energy_J(moments, state.q_rad) : 0.0) +
           (stops ? stop_energy_J(limits, state.q_rad) : 0.0);
}

/// One solution of the equations in the header. Nothing where the iterations do not settle.
std::optional<LinkageMotion> undivided_step(const LinkagePlant &plant, const LinkageState &before,
                                            const LinkageLoad &load, double h,
                                            std::array<FrictionMode, 3> &modes) {
    const Vector3 &q_a = before.q_rad;
    const Vector3 &rate_a = before.rate_rad_per_s;
    const Vector3 momentum_a = inertia_with_rotors(plant, q_a) * rate_a;
    FrictionRange friction = FrictionRange::after(rate_a, plant.coulomb_Nm);
    friction.lowest *= h;
    friction.highest *= h;

    LinkageMotion motion;
    motion.mean_rate_rad_per_s = rate_a;
    for (int iteration = 0; iteration < kMostIterations; ++iteration) {
        const Vector3 q_b = q_a + h * motion.mean_rate_rad_per_s;
        const Matrix3 tip_jacobian = tip_secant(plant.geometry, q_a, q_b);
        Matrix3 damping = load.tip_damping_Ns_per_m * (tip_jacobian.transpose() * tip_jacobian);
        damping.diagonal() += load.damping_Nms_per_rad;
        Vector3 torque = load.torque_Nm + tip_jacobian.transpose() * load.tip_force_N;
        if (plant.gravity) {
            torque -= gravity_secant_Nm(plant.moments, q_a, q_b);
        }
        if (plant.stops) {
            const StopTorque pressed = stop_torque(plant.limits, q_a, q_b);
            torque += pressed.torque_Nm;
            damping += pressed.damping_Nms_per_rad;
        }
        const Matrix3 system = inertia_with_rotors(plant, q_b) + 0.5 * h * damping -
                               h * inertia_secant(plant.moments, q_a, q_b, rate_a);
        const Vector3 right = momentum_a + h * torque - 0.5 * h * (damping * rate_a);
        const Vector3 rate_b = solve_with_friction(system, right, friction, modes);
        const Vector3 mean_rate = 0.5 * (rate_a + rate_b);
        const double moved = h * (mean_rate - motion.mean_rate_rad_per_s).cwiseAbs().maxCoeff();
        motion.mean_rate_rad_per_s = mean_rate;
        if (moved <= std::max(kSettled_rad, kEpsilon * q_a.cwiseAbs().maxCoeff())) {
            motion.after = {q_a + h * mean_rate, rate_b};
            motion.mean_tip_velocity_m_per_s = tip_jacobian * mean_rate;
            return motion;
        }
    }
    return std::nullopt;
}

/// The same in so many equal pieces.
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

LinkageMotion linkage_step(const LinkagePlant &plant, const LinkageState &before,
                           const LinkageLoad &load, double step_s,
                           std::array<FrictionMode, 3> &modes) noexcept {
    std::optional<LinkageMotion> motion = undivided_step(plant, before, load, step_s, modes);
    for (int pieces = 2; !motion && pieces <= kMostPieces; pieces *= 2) {
        motion = divided_step(plant, before, load, step_s, pieces, modes);
    }
    if (motion) {
        return *motion;
    }
    LinkageMotion stopped; // beyond all that the model is for: at rest, rather than anywhere
    stopped.after.q_rad = before.q_rad;
    return stopped;
}

} // namespace springdrive

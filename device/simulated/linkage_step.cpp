#include "device/simulated/linkage_step.h"

namespace springdrive {

namespace {

/// Iterations end when the angles at the end of the step move by no more than this: round-off.
constexpr double kSettled_rad = 2e-16;
constexpr int kMostIterations = 12;

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

LinkageMotion linkage_step(const LinkagePlant &plant, const LinkageState &before,
                           const LinkageLoad &load, double step_s,
                           std::array<FrictionMode, 3> &modes) noexcept {
    const double h = step_s;
    const Vector3 &q_a = before.q_rad;
    const Vector3 &rate_a = before.rate_rad_per_s;
    const Vector3 momentum_a = inertia_with_rotors(plant, q_a) * rate_a;
    FrictionRange friction = FrictionRange::after(rate_a, plant.coulomb_Nm);
    friction.lowest *= h;
    friction.highest *= h;

    LinkageMotion motion;
    motion.after.rate_rad_per_s = rate_a;
    motion.mean_rate_rad_per_s = rate_a;
    Matrix3 tip_jacobian;
    for (int iteration = 0; iteration < kMostIterations; ++iteration) {
        const Vector3 q_b = q_a + h * motion.mean_rate_rad_per_s;
        tip_jacobian = tip_secant(plant.geometry, q_a, q_b);
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
        motion.after.rate_rad_per_s = rate_b;
        motion.mean_rate_rad_per_s = mean_rate;
        if (moved <= kSettled_rad) {
            break;
        }
    }
    motion.after.q_rad = q_a + h * motion.mean_rate_rad_per_s;
    motion.mean_tip_velocity_m_per_s = tip_jacobian * motion.mean_rate_rad_per_s;
    return motion;
}

} // namespace springdrive

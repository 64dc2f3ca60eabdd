// Where sampled loops become unstable: drift compensation (10), the scale of the transpose map
// (23), and the virtual wall of a current drive.
#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/control/velocity_filter.h"
#include "engine/lab/limits/method_limits/experiment_list.h"

#include <cmath>
#include <numbers>

namespace springdrive::limits {

namespace {

constexpr const char *kDrift = "drift compensation (10)";

Experiment loop_experiment(const char *method, const std::string &setting,
                           const loops::StabilityCase &which, const char *parameter) {
    return {.row = {method, {}, {}, setting},
            .loop = LoopSweep{which, loops::stability_parameter_named(parameter)}};
}

/// The change of e_W from one encoder count.
Experiment noise_of_a_count(const loops::StabilityCase &which) {
    const control::Tuning tuning;
    const double count_rad = which.device.rad_per_count();
    const double a = control::velocity_filter_pole(tuning.lambda_rad_per_s, which.period_s);
    return {
        .row = {kDrift, "e_W changes per count by", "mV",
                "(K_P + K_D (1 − a)/T) Δ, tuning firm, 1 kHz",
                1e3 * count_rad *
                    (tuning.K_P_V_per_rad + tuning.K_D_Vs_per_rad * (1.0 - a) / which.period_s)},
        .reading = [=] {
            control::VelocityFilter filter;
            control::Configuration now;
            now.theta_rad = Vector3(count_rad, 0.0, 0.0);
            now.theta_rate_rad_per_s = filter.update(now.theta_rad, a, which.period_s);
            const Vector3 e_W_V = control::drift_compensation_V(
                control::torque_constants(which.device), tuning, now, {});
            return std::optional(1e3 * std::abs(e_W_V[0]));
        }};
}

} // namespace

Experiments drift_experiments(const loops::StabilityCase &which) {
    Experiments all;
    for (const char *name : {"kp", "kd", "dR", "T", "d"}) {
        all.push_back(loop_experiment(kDrift, "tuning firm, 1 kHz", which, name));
    }
    loops::StabilityCase filtered = which; // stable only with K_D, not with K_P alone
    filtered.tuning.K_P_V_per_rad = 20.0;
    filtered.tuning.K_D_Vs_per_rad = 0.03;
    filtered.delay_periods = 1;
    all.push_back(
        loop_experiment(kDrift, "K_P 20 V/rad, K_D 0.03 V·s/rad, delay 1", filtered, "lambda"));
    all.push_back(noise_of_a_count(which));
    return all;
}

Experiments alpha_experiments(const loops::StabilityCase &which) {
    loops::StabilityCase three = which;
    three.freedom = loops::Freedom::three_motors;
    three.tuning.K_P_V_per_rad = 20.0; // near the largest that is stable at the bound (29)
    const double bound =
        control::alpha_bound(device::motor_jacobian(which.device.geometry, which.q_rad),
                             control::relative_stiffness(which.device));
    return {loop_experiment(kTransposeKinematics,
                            "K_P 20 V/rad; the bound (29) is " +
                                with_unit(std::round(bound), "rad²/m²"),
                            three, "alpha")};
}

Experiments wall_experiments(const loops::StabilityCase &which) {
    loops::StabilityCase wall = which;
    wall.drive = device::AmplifierKind::current_drive;
    wall.hands = {loops::no_hand()};
    wall.rotor = device::RotorLoad{1e-4, 1e-3, 0.0};
    wall.wall = {1.0, 0.0};
    const double lever_m = device::motor_jacobian(which.device.geometry, which.q_rad).col(1).norm();
    const double lag_s =
        1.0 / (2.0 * std::numbers::pi * which.device.amplifier.current_bandwidth_hz);
    Experiments all;
    for (const char *setting : {"J 1e-4 kg·m², b 1e-3 N·m·s/rad, B 0; 2b/(T + 2/ω) is ",
                                "the same, delay 1; 2b/(3T + 2/ω) is "}) {
        // 2b/T, corrected for a delay of d periods and for the amplifier's lag.
        const double late_s = wall.period_s * (1.0 + 2.0 * wall.delay_periods) + 2.0 * lag_s;
        const double limit_N_per_m =
            2.0 * wall.rotor->damping_Nms_per_rad / (late_s * lever_m * lever_m);
        all.push_back(loop_experiment("current-drive wall",
                                      setting + with_unit(std::round(limit_N_per_m), "N/m"), wall,
                                      "wall-stiffness"));
        wall.delay_periods += 1.0;
    }
    return all;
}

} // namespace springdrive::limits

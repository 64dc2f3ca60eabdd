#include "engine/lab/limits/method_limits/loop_limits.h"

#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/control/velocity_filter.h"
#include "engine/lab/limits/method_limits/limit_trials.h"
#include "engine/lab/limits/stability_limits.h"

#include <cmath>
#include <numbers>

namespace springdrive::limits {

namespace {

constexpr const char *kDrift = "drift compensation (10)";

/// The limits of one parameter of a loop.
void add_limits(std::vector<MethodLimit> &lines, const std::string &method,
                const loops::StabilityCase &which, const std::string &name,
                const std::string &setting) {
    const loops::StabilityParameter &parameter = *loops::stability_parameter_named(name);
    for (const StabilityLimit &limit :
         stability_limits(which, parameter, {parameter.from, parameter.to})) {
        lines.push_back({method,
                         std::string(parameter.symbol) + (limit.stable_below ? " above" : " below"),
                         std::string(parameter.unit), setting, limit.predicted,
                         limit.simulated_linear, limit.simulated_all});
    }
}

/// The change of e_W from one encoder count.
MethodLimit noise_of_a_count(const loops::StabilityCase &which) {
    const control::Tuning tuning;
    const double count_rad = which.device.rad_per_count();
    const double a = control::velocity_filter_pole(tuning.lambda_rad_per_s, which.period_s);
    control::VelocityFilter filter;
    control::Configuration now;
    now.theta_rad = Vector3(count_rad, 0.0, 0.0);
    now.theta_rate_rad_per_s = filter.update(now.theta_rad, a, which.period_s);
    const Vector3 e_W_V =
        control::drift_compensation_V(control::torque_constants(which.device), tuning, now, {});
    return {kDrift,
            "e_W changes per count by",
            "mV",
            "(K_P + K_D (1 − a)/T) Δ, tuning firm, 1 kHz",
            1e3 * count_rad *
                (tuning.K_P_V_per_rad + tuning.K_D_Vs_per_rad * (1.0 - a) / which.period_s),
            1e3 * std::abs(e_W_V[0]),
            std::nullopt};
}

} // namespace

std::vector<MethodLimit> drift_limits(const loops::StabilityCase &which,
                                      const std::function<void()> &step) {
    std::vector<MethodLimit> lines;
    loops::StabilityCase firm = which;
    firm.tuning = control::Tuning{};
    for (const char *name : {"kp", "kd", "dR", "T", "d"}) {
        add_limits(lines, kDrift, firm, name, "tuning firm, 1 kHz");
        step();
    }
    loops::StabilityCase filtered = firm; // stable only with K_D, not with K_P alone
    filtered.tuning.K_P_V_per_rad = 20.0;
    filtered.tuning.K_D_Vs_per_rad = 0.03;
    filtered.delay_periods = 1;
    add_limits(lines, kDrift, filtered, "lambda", "K_P 20 V/rad, K_D 0.03 V·s/rad, delay 1");
    step();
    lines.push_back(noise_of_a_count(which));
    step();
    return lines;
}

std::vector<MethodLimit> alpha_limits(const loops::StabilityCase &which) {
    std::vector<MethodLimit> lines;
    loops::StabilityCase three = which;
    three.freedom = loops::Freedom::three_motors;
    three.tuning = control::Tuning{};
    three.tuning.K_P_V_per_rad = 20.0; // near the largest that is stable at the bound (29)
    const double bound =
        control::alpha_bound(device::motor_jacobian(which.device.geometry, which.q_rad),
                             control::relative_stiffness(which.device));
    add_limits(lines, kTransposeKinematics, three, "alpha",
               "K_P 20 V/rad; the bound (29) is " + with_unit(std::round(bound), "rad²/m²"));
    return lines;
}

std::vector<MethodLimit> wall_limits(const loops::StabilityCase &which) {
    std::vector<MethodLimit> lines;
    loops::StabilityCase wall = which;
    wall.drive = device::AmplifierKind::current_drive;
    wall.hands = {loops::no_hand()};
    wall.rotor = device::RotorLoad{1e-4, 1e-3, 0.0};
    wall.wall = {1.0, 0.0};
    const double lever_m = device::motor_jacobian(which.device.geometry, which.q_rad).col(1).norm();
    const double lag_s =
        1.0 / (2.0 * std::numbers::pi * which.device.amplifier.current_bandwidth_hz);
    // 2b/T, corrected for a delay of d periods and for the amplifier's lag.
    const auto line = [&](int delay) {
        const double late_s = wall.period_s * (1.0 + 2.0 * delay) + 2.0 * lag_s;
        return with_unit(
            std::round(2.0 * wall.rotor->damping_Nms_per_rad / (late_s * lever_m * lever_m)),
            "N/m");
    };
    add_limits(lines, "current-drive wall", wall, "wall-stiffness",
               "J 1e-4 kg·m², b 1e-3 N·m·s/rad, B 0; 2b/(T + 2/ω) is " + line(0));
    wall.delay_periods = 1;
    add_limits(lines, "current-drive wall", wall, "wall-stiffness",
               "the same, delay 1; 2b/(3T + 2/ω) is " + line(1));
    return lines;
}

} // namespace springdrive::limits

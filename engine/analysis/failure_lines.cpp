#include "engine/analysis/failure_lines.h"

#include "base/print.h"
#include "device/motor/winding_temperature.h"
#include "device/phantom/kinematics.h"
#include "engine/analysis/stability/stability_limits.h"
#include "engine/analysis/thermal_hold.h"
#include "engine/analysis/work_precision/closest_point.h"
#include "engine/analysis/work_precision/integrators.h"
#include "engine/control/haptic_law.h"
#include "engine/control/velocity_filter.h"
#include "engine/scenario/test_surfaces.h"

#include <cmath>
#include <numbers>
#include <sstream>

namespace springdrive {

namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

std::string text(double value, const char *unit) {
    std::ostringstream out;
    out << value << ' ' << unit;
    return out.str();
}

/// Where a verdict changes between a value that holds and one that does not.
double turning_point(double holds_at, double fails_at, const std::function<bool(double)> &holds) {
    for (int halving = 0; halving < 50; ++halving) {
        const double middle = 0.5 * (holds_at + fails_at);
        (holds(middle) ? holds_at : fails_at) = middle;
    }
    return holds_at;
}

/// Limits of one parameter of a loop.
void add_limits(std::vector<FailureLine> &lines, const std::string &method,
                const StabilityCase &which, const std::string &name, const std::string &setting) {
    const StabilityParameter &parameter = *stability_parameter_named(name);
    for (const StabilityLimit &limit :
         stability_limits(which, parameter, {parameter.from, parameter.to})) {
        lines.push_back({method,
                         std::string(parameter.symbol) + (limit.stable_below ? " above" : " below"),
                         std::string(parameter.unit), setting, limit.predicted,
                         limit.simulated_linear, limit.simulated_all});
    }
}

/// R falls below R̂ as a winding cools: held still, its current then grows.
FailureLine over_cancelled(const StabilityCase &which) {
    constexpr double dR_Ohm = 0.1;
    const MotorParameters &motor = which.device.motor[1];
    StabilityCase held = which;
    held.hands = {no_hand()};
    held.rotor = RotorLoad{1e3, 0.0, 0.0}; // nothing moves it
    held.tuning.K_P_V_per_rad = held.tuning.K_D_Vs_per_rad = 0.0;
    held.freedom = Freedom::one_motor;
    const double R_hat_Ohm = motor.resistance_Ohm - dR_Ohm;
    const auto grows = [&](double winding_C) {
        const double rise = motor.resistance_rise_per_K * (winding_C - kReferenceTemperature_C);
        const WindingStep step =
            winding_step(motor, motor.resistance_Ohm * (1.0 + rise) - R_hat_Ohm, 1e-4);
        double current_A = 1e-3;
        for (int i = 0; i < 1000; ++i) {
            current_A *= step.decay;
        }
        return current_A > 1e-3;
    };
    const double predicted_C =
        kReferenceTemperature_C - dR_Ohm / (motor.resistance_rise_per_K * motor.resistance_Ohm);
    return {"resistance cancellation (6)",
            "winding cooler than",
            "°C",
            "R̂ tuned for dR " + text(dR_Ohm, "Ω") + " at 25 °C, rotor held",
            predicted_C,
            turning_point(25.0, -40.0, [&](double winding_C) { return !grows(winding_C); }),
            std::nullopt};
}

/// With l₁ = l₂ and N₂ = N₃ there are closed forms.
bool has_even_links(const DeviceDescription &device) {
    return device.geometry.upper_arm_m == device.geometry.forearm_m &&
           device.geometry.transmission_ratio[1] == device.geometry.transmission_ratio[2];
}

std::optional<double> if_links_are_even(const DeviceDescription &device, double predicted) {
    return has_even_links(device) ? std::optional(predicted) : std::nullopt;
}

/// The folded device of (18): the upper arm level, q₃ − q₂ = `fold_rad`.
Configuration folded(const DeviceDescription &device, double fold_rad) {
    const Vector3 q_rad(0.0, 0.0, fold_rad);
    return HapticLaw(device).configuration(motor_from_joint(device.geometry, q_rad),
                                           Vector3::Zero());
}

/// The greatest way of the motors' set-point per way of the tip's, over directions in the links'
/// plane [rad/m]; infinite where (18) has no answer for one of them.
double set_point_reach(const DeviceDescription &device, const Configuration &now, double way_m) {
    double greatest = 0.0;
    for (int i = 0; i < 720; ++i) {
        const double angle = i * std::numbers::pi / 360.0;
        const TipSetPoint target{now.tip_m + way_m * Vector3(0.0, std::cos(angle), std::sin(angle)),
                                 Vector3::Zero()};
        const std::optional<MotorSetPoint> found = inverse_map(device.geometry, now, target);
        greatest = std::max(greatest, found ? (found->theta_Sd_rad - now.theta_rad).norm() / way_m
                                            : HUGE_VAL);
    }
    return greatest;
}

/// Near q₃ − q₂ = 90° J⁻¹ grows without bound: the least singular value of J is
/// l √(1 − |sin(q₃ − q₂)|)/N with l₁ = l₂ = l and N₂ = N₃ = N.
FailureLine exploding_inverse(const StabilityCase &which) {
    constexpr double kTimes = 5.0;
    constexpr double kWay_m = 1e-7;
    const DeviceDescription &device = which.device;
    const double square = set_point_reach(device, folded(device, 0.0), kWay_m);
    return {"inverse kinematics (18)",
            "q₃ − q₂ above",
            "°",
            "set-points go 5 times as far as at q₃ = q₂",
            if_links_are_even(device, kDegrees * std::asin(1.0 - 1.0 / (kTimes * kTimes))),
            kDegrees * turning_point(0.0, 0.5 * std::numbers::pi,
                                     [&](double fold_rad) {
                                         return set_point_reach(device, folded(device, fold_rad),
                                                                kWay_m) < kTimes * square;
                                     }),
            std::nullopt};
}

/// A set-point farther out than both links reach, l √(2 (1 + sin(q₃ − q₂))) from the shoulder.
FailureLine unreachable_inverse(const StabilityCase &which) {
    constexpr double kOut_m = 1e-3;
    const DeviceDescription &device = which.device;
    const double share = 2.0 - kOut_m / device.geometry.upper_arm_m;
    return {"inverse kinematics (18)",
            "q₃ − q₂ above",
            "°",
            "a set-point 1 mm away is out of reach",
            if_links_are_even(device, kDegrees * std::asin(0.5 * share * share - 1.0)),
            kDegrees * turning_point(0.0, 0.5 * std::numbers::pi,
                                     [&](double fold_rad) {
                                         return std::isfinite(set_point_reach(
                                             device, folded(device, fold_rad), kOut_m));
                                     }),
            std::nullopt};
}

/// 2L/R: a winding by explicit Euler.
FailureLine explicit_euler(const StabilityCase &which, double net_Ohm, const std::string &setting) {
    const double L = which.device.motor[1].inductance_H;
    using State = Eigen::Matrix<double, 1, 1>;
    const auto rates = [&](double, const State &current) -> State {
        return -net_Ohm / L * current;
    };
    const auto dies_out = [&](double h) {
        State current = State::Ones();
        for (int i = 0; i < 1000; ++i) {
            current = explicit_euler_step(rates, 0.0, current, h);
        }
        return std::abs(current[0]) < 1.0;
    };
    return {"explicit Euler",
            "step above",
            "µs",
            setting,
            1e6 * 2.0 * L / net_Ohm,
            1e6 * turning_point(0.0, 10.0 * L / net_Ohm, dies_out),
            std::nullopt};
}

/// 2.785 L/R: the same by the classical method of fourth order.
FailureLine runge_kutta(const StabilityCase &which) {
    const MotorParameters &motor = which.device.motor[1];
    using State = Eigen::Matrix<double, 1, 1>;
    const auto rates = [&](double, const State &current) -> State {
        return -motor.resistance_Ohm / motor.inductance_H * current;
    };
    const auto dies_out = [&](double h) {
        State current = State::Ones();
        for (int i = 0; i < 1000; ++i) {
            current = runge_kutta_step(rates, 0.0, current, h);
        }
        return std::abs(current[0]) < 1.0;
    };
    constexpr double kRealLimit = 2.785293563405282; // where 1 − z + z²/2 − z³/6 + z⁴/24 = 1
    const double time_s = motor.inductance_H / motor.resistance_Ohm;
    return {"Runge-Kutta 4",
            "step above",
            "µs",
            "R̂ = 0, rotor held",
            1e6 * kRealLimit * time_s,
            1e6 * turning_point(0.0, 10.0 * time_s, dies_out),
            std::nullopt};
}

/// What one count of an encoder makes of e_W.
FailureLine noise_of_a_count(const StabilityCase &which) {
    const Tuning tuning;
    const double count_rad = 2.0 * std::numbers::pi / which.device.encoder_counts_per_turn;
    const double a = velocity_filter_pole(tuning.lambda_rad_per_s, which.period_s);
    VelocityFilter filter;
    Configuration now;
    now.theta_rad = Vector3(count_rad, 0.0, 0.0);
    now.theta_rate_rad_per_s = filter.update(now.theta_rad, a, which.period_s);
    const Vector3 e_W_V = drift_compensation_V(torque_constants(which.device), tuning, now, {});
    return {"drift compensation (10)",
            "a count makes",
            "mV",
            "(K_P + K_D (1 − a)/T) Δ, tuning firm, 1 kHz",
            1e3 * count_rad *
                (tuning.K_P_V_per_rad + tuning.K_D_Vs_per_rad * (1.0 - a) / which.period_s),
            1e3 * std::abs(e_W_V[0]),
            std::nullopt};
}

/// Near the base's axis a set-point to the side turns the base far: N/r.
FailureLine base_axis(const StabilityCase &which) {
    constexpr double kTimes = 5.0;
    constexpr double kWay_m = 1e-7;
    const DeviceDescription &device = which.device;
    const double l1 = device.geometry.upper_arm_m;
    const auto turn = [&](double r_m) { // r = l₁ cos q₂ with the forearm hanging down
        const Vector3 q_rad(0.0, std::acos(std::min(1.0, r_m / l1)), 0.0);
        const Configuration now = HapticLaw(device).configuration(
            motor_from_joint(device.geometry, q_rad), Vector3::Zero());
        const std::optional<MotorSetPoint> found = inverse_map(
            device.geometry, now, {now.tip_m + kWay_m * Vector3::UnitX(), Vector3::Zero()});
        return found ? std::abs(found->theta_Sd_rad[0] - now.theta_rad[0]) : HUGE_VAL;
    };
    const double usual = turn(l1);
    return {"inverse kinematics (18)",
            "r below",
            "mm",
            "the base's set-point goes 5 times as far as at r = l₁",
            1e3 * l1 / kTimes,
            1e3 * turning_point(l1, 0.1 * l1, [&](double r) { return turn(r) < kTimes * usual; }),
            std::nullopt};
}

/// A tip that is pressed more than half way through a plate is nearer to its other side.
FailureLine closest_point_in_a_plate() {
    constexpr double kThickness_m = 2e-3;
    const auto plate = [] {
        TriangleSoup soup;
        const auto add = [&](const Vector3 &a, const Vector3 &b, const Vector3 &c) {
            const auto first = static_cast<std::uint32_t>(soup.vertices_m.size());
            soup.vertices_m.insert(soup.vertices_m.end(), {a, b, c});
            soup.triangles.push_back({first, first + 1, first + 2});
        };
        const auto square = [&](double y, double up) {
            const Vector3 a(-0.05, y, -0.05 * up);
            const Vector3 b(-0.05, y, 0.05 * up);
            const Vector3 c(0.05, y, 0.05 * up);
            const Vector3 d(0.05, y, -0.05 * up);
            add(a, b, c);
            add(a, c, d);
        };
        square(0.0, 1.0);
        square(-kThickness_m, -1.0);
        return soup;
    };
    const TriangleSoup soup = plate();
    ClosestPointFinder finder(soup);
    return {"closest point (penalty)",
            "pressed in deeper than",
            "mm",
            "a plate of " + text(1e3 * kThickness_m, "mm"),
            1e3 * 0.5 * kThickness_m,
            1e3 * turning_point(0.0, kThickness_m,
                                [&](double depth_m) {
                                    const Vector3 tip(0.01, -depth_m, 0.02);
                                    return finder.closest(tip).point_m.y() > -0.5 * kThickness_m;
                                }),
            std::nullopt};
}

/// A held contact warms the windings: K_DC = k_T K_P/dR falls as R rises.
FailureLine warm_contact(const StabilityCase &which) {
    ThermalHoldOptions options;
    options.force_N = 1.4;
    options.seconds = 60.0;
    const std::vector<ThermalRow> rows = thermal_hold(which.device, options);
    const ThermalRow &cold = rows.front();
    const ThermalRow *hot = &cold;
    for (const ThermalRow &row : rows) {
        hot = row.phase == ThermalPhase::hold ? &row : hot;
    }
    // (7): dR grows by what R does.
    const MotorParameters &motor = which.device.motor[1];
    const double warmer_K = hot->winding_C[1] - cold.winding_C[1];
    const double dR_Ohm =
        cold.dR_Ohm[1] + motor.resistance_Ohm * motor.resistance_rise_per_K * warmer_K;
    return {"held contact",
            "K_DC falls to",
            "%",
            "1.4 N for 60 s, dR " + text(options.tuning.dR_Ohm, "Ω") + ", motor 2",
            100.0 * cold.dR_Ohm[1] / dR_Ohm,
            100.0 * hot->K_DC_Nm_per_rad[1] / cold.K_DC_Nm_per_rad[1],
            std::nullopt};
}

void add_drift_compensation(std::vector<FailureLine> &lines, const StabilityCase &which,
                            const std::function<void()> &step) {
    const std::string method = "drift compensation (10)";
    StabilityCase firm = which;
    firm.tuning = Tuning{};
    for (const char *name : {"kp", "kd", "dR", "T", "d"}) {
        add_limits(lines, method, firm, name, "tuning firm, 1 kHz");
        step();
    }
    StabilityCase filtered = firm; // K_D holds what K_P alone would not
    filtered.tuning.K_P_V_per_rad = 20.0;
    filtered.tuning.K_D_Vs_per_rad = 0.03;
    filtered.delay_samples = 1;
    add_limits(lines, method, filtered, "lambda", "K_P 20 V/rad, K_D 0.03 V·s/rad, delay 1");
    step();
}

void add_transpose(std::vector<FailureLine> &lines, const StabilityCase &which) {
    StabilityCase three = which;
    three.freedom = Freedom::three_motors;
    three.tuning = Tuning{};
    three.tuning.K_P_V_per_rad = 20.0; // near what (29) leaves room for
    const double bound = alpha_bound(motor_jacobian(which.device.geometry, which.q_rad),
                                     relative_stiffness(which.device));
    add_limits(lines, "transpose kinematics (23)", three, "alpha",
               "K_P 20 V/rad; the bound (29) is " + text(std::round(bound), "rad²/m²"));
}

void add_wall(std::vector<FailureLine> &lines, const StabilityCase &which) {
    StabilityCase wall = which;
    wall.drive = AmplifierKind::current_drive;
    wall.hands = {no_hand()};
    wall.rotor = RotorLoad{1e-4, 1e-3, 0.0};
    wall.wall = {1.0, 0.0};
    const double lever_m = motor_jacobian(which.device.geometry, which.q_rad).col(1).norm();
    const double lag_s =
        1.0 / (2.0 * std::numbers::pi * which.device.amplifier.current_bandwidth_hz);
    // 2b/T, for a command that comes d samples late and an amplifier that lags.
    const auto line = [&](int delay) {
        const double late_s = wall.period_s * (1.0 + 2.0 * delay) + 2.0 * lag_s;
        return text(
            std::round(2.0 * wall.rotor->damping_Nms_per_rad / (late_s * lever_m * lever_m)),
            "N/m");
    };
    add_limits(lines, "current-drive wall", wall, "wall-stiffness",
               "J 1e-4 kg·m², b 1e-3 N·m·s/rad, B 0; 2b/(T + 2/ω) is " + line(0));
    wall.delay_samples = 1;
    add_limits(lines, "current-drive wall", wall, "wall-stiffness",
               "the same, delay 1; 2b/(3T + 2/ω) is " + line(1));
}

} // namespace

std::vector<FailureLine> failure_lines(const StabilityCase &which,
                                       const std::function<void(double)> &progress) {
    constexpr double kSteps = 17.0;
    double done = 0.0;
    const auto step = [&] { progress(++done / kSteps); };
    std::vector<FailureLine> lines;
    const auto add = [&](FailureLine line) {
        lines.push_back(std::move(line));
        step();
    };
    add(over_cancelled(which));
    add_drift_compensation(lines, which, step);
    add(noise_of_a_count(which));
    add(exploding_inverse(which));
    add(unreachable_inverse(which));
    add(base_axis(which));
    add_transpose(lines, which);
    step();
    add_wall(lines, which);
    step();
    const double dR_Ohm = Tuning{}.dR_Ohm;
    add(explicit_euler(which, which.device.motor[1].resistance_Ohm, "R̂ = 0, rotor held"));
    add(explicit_euler(which, dR_Ohm, "dR " + text(dR_Ohm, "Ω") + ", rotor held"));
    add(runge_kutta(which));
    add(closest_point_in_a_plate());
    add(warm_contact(which));
    return lines;
}

void write_failure_lines(std::ostream &out, const std::vector<FailureLine> &lines) {
    const auto number = [](const std::optional<double> &value) {
        std::ostringstream digits;
        digits.precision(4);
        if (value) {
            digits << *value;
        } else {
            digits << "–";
        }
        return digits.str();
    };
    out << "| method | fails | setting | predicted | measured | as it is |\n"
           "| --- | --- | --- | ---: | ---: | ---: |\n";
    for (const FailureLine &line : lines) {
        out << "| " << line.method << " | " << line.fails << " (" << line.unit << ") | "
            << line.setting << " | " << number(line.predicted) << " | " << number(line.measured)
            << " | " << number(line.measured_as_it_is) << " |\n";
    }
}

} // namespace springdrive

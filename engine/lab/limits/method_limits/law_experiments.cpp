// The law: where its sampled loops become unstable (drift compensation (10), the scale of the
// transpose map (23), the virtual wall of a current drive), inverse kinematics (18), the direction
// under the transpose map, and the limiter behind it.
#include "base/bisection.h"
#include "base/degrees.h"
#include "device/core/motor/motor.h"
#include "device/core/motor/winding_heat.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/haptic_law.h"
#include "engine/control/motion_control.h"
#include "engine/control/rendered_force.h"
#include "engine/control/velocity_filter.h"
#include "engine/lab/limits/method_limits/experiment_list.h"
#include "engine/lab/loops/link_plane.h"
#include "engine/lab/rig/law_rig.h"
#include "engine/servo/command_limiter.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <utility>

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

namespace {

/// l₁ = l₂ and N₂ = N₃, for which there are closed forms.
bool has_even_links(const device::PhantomGeometry &geometry) {
    return geometry.upper_arm_m == geometry.forearm_m &&
           geometry.transmission_ratio[1] == geometry.transmission_ratio[2];
}

std::optional<double> if_links_are_even(const device::DeviceDescription &device, double predicted) {
    return has_even_links(device.geometry) ? std::optional(predicted) : std::nullopt;
}

// Inverse kinematics.

constexpr const char *kKinematicsMethod = "inverse kinematics (18)";
constexpr TriedValues kFolds_deg{0.0, 90.0}; ///< to where the links are aligned
constexpr double kTimes = 5.0;               ///< the amplification that counts as a failure
constexpr double kWay_m = 1e-7;              ///< so short that the map is linear

control::Configuration at_rest(const device::DeviceDescription &device, const Vector3 &q_rad) {
    return control::HapticLaw(device).configuration(
        device::motor_from_joint(device.geometry, q_rad), Vector3::Zero());
}

/// The motors' displacement for a displacement of the tip's set-point; nothing where (18) has no
/// solution.
std::optional<Vector3> moved_rad(const device::DeviceDescription &device,
                                 const control::Configuration &now, const Vector3 &way_m) {
    const std::optional<control::MotorSetPoint> found =
        control::inverse_map(device.geometry, now, {now.tip_m + way_m, Vector3::Zero()});
    return found ? std::optional<Vector3>(found->theta_Sd_rad - now.theta_rad) : std::nullopt;
}

/// The largest displacement of the motors' set-point per displacement of the tip's, over directions
/// in the links' plane [rad/m]; infinite where (18) has no solution for one of them. The upper arm
/// is level.
double set_point_reach(const device::DeviceDescription &device, double fold_deg, double way_m) {
    constexpr int kDirections = 720;
    const control::Configuration now =
        at_rest(device, Vector3(0.0, 0.0, fold_deg / kDegreesPerRadian));
    double maximum = 0.0;
    for (int i = 0; i < kDirections; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / kDirections;
        const std::optional<Vector3> moved =
            moved_rad(device, now, way_m * Vector3(0.0, std::cos(angle), std::sin(angle)));
        maximum = std::max(maximum, moved ? moved->norm() / way_m : HUGE_VAL);
    }
    return maximum;
}

/// Near q₃ − q₂ = 90° J⁻¹ grows without bound: the smallest singular value of J is l √(1 − |sin(q₃
/// − q₂)|)/N with l₁ = l₂ = l and N₂ = N₃ = N.
Experiment exploding(const device::DeviceDescription &device) {
    const double square = set_point_reach(device, 0.0, kWay_m);
    return {
        {kKinematicsMethod, "q₃ − q₂ above", "°", "set-points move 5 times as far as at q₃ = q₂",
         if_links_are_even(device, kDegreesPerRadian * std::asin(1.0 - 1.0 / (kTimes * kTimes)))},
        kFolds_deg,
        [=](double fold_deg) {
            return set_point_reach(device, fold_deg, kWay_m) < kTimes * square;
        }};
}

/// A set-point beyond the reach of both links, l √(2 (1 + sin(q₃ − q₂))) from the shoulder.
Experiment unreachable(const device::DeviceDescription &device) {
    constexpr double kOut_m = 1e-3;
    const double share = 2.0 - kOut_m / device.geometry.upper_arm_m;
    return {
        {kKinematicsMethod, "q₃ − q₂ above", "°", "a set-point 1 mm away is out of reach",
         if_links_are_even(device, kDegreesPerRadian * std::asin(0.5 * share * share - 1.0))},
        kFolds_deg,
        [=](double fold_deg) { return std::isfinite(set_point_reach(device, fold_deg, kOut_m)); }};
}

/// How far the base's set-point turns for a sideways displacement, at r = l₁ cos q₂, with the
/// forearm hanging down [rad].
double turn_rad(const device::DeviceDescription &device, double r_m) {
    const double q2_rad = std::acos(std::min(1.0, r_m / device.geometry.upper_arm_m));
    const std::optional<Vector3> moved =
        moved_rad(device, at_rest(device, Vector3(0.0, q2_rad, 0.0)), kWay_m * Vector3::UnitX());
    return moved ? std::abs(moved->x()) : HUGE_VAL;
}

/// Near the base's axis a sideways set-point turns the base far: N/r.
Experiment base_axis(const device::DeviceDescription &device) {
    const double l1_mm = 1e3 * device.geometry.upper_arm_m;
    const double usual_rad = turn_rad(device, device.geometry.upper_arm_m);
    return {{kKinematicsMethod, "r below", "mm",
             "the base's set-point moves 5 times as far as at r = l₁", l1_mm / kTimes},
            {l1_mm, 0.1 * l1_mm},
            [=](double r_mm) { return turn_rad(device, 1e-3 * r_mm) < kTimes * usual_rad; }};
}

// Direction under vibration.

double rate_rad_per_s(double frequency_hz) { return 2.0 * std::numbers::pi * frequency_hz; }

/// Windings of motors whose rotors are locked, except for one that vibrates.
class VibratingRotors final : public rig::Plant {
public:
    static constexpr double kAmplitude_rad = 1e-5; ///< so small that J is constant

    /// Receives the currents at the end of each sub-step.
    using Watch = std::function<void(double time_s, const Vector3 &current_A)>;

    VibratingRotors(const device::DeviceDescription &device, const Vector3 &rest_rad,
                    Eigen::Index shaken, double omega_rad_per_s, double period_s, Watch watch)
        : device_(device), rest_rad_(rest_rad), shaken_(shaken), omega_(omega_rad_per_s),
          period_s_(period_s), watch_(std::move(watch)) {}

    [[nodiscard]] double time_s() const { return static_cast<double>(periods_) * period_s_; }
    [[nodiscard]] Vector3 theta_rad() const override { return theta_rad(time_s()); }

    void advance(const simulated::PlantCommand &command) override {
        constexpr int kSubSteps = 10;
        const double h = period_s_ / kSubSteps;
        for (int sub = 0; sub < kSubSteps; ++sub) {
            const double before_s = time_s() + sub * h;
            step(command.spring_drive, before_s, h);
            watch_(before_s + h, current_A_);
        }
        ++periods_;
    }

private:
    [[nodiscard]] Vector3 theta_rad(double time_s) const {
        Vector3 theta = rest_rad_;
        theta[shaken_] += kAmplitude_rad * std::cos(omega_ * time_s);
        return theta;
    }

    void step(const device::DeviceCommand &command, double before_s, double h) {
        const Vector3 rate = (theta_rad(before_s + h) - theta_rad(before_s)) / h;
        for (Eigen::Index j = 0; j < 3; ++j) {
            const device::MotorParameters &motor = device_.motor[static_cast<std::size_t>(j)];
            const device::DriveState now{motor.resistance_Ohm, current_A_[j], rate[j], true};
            current_A_[j] = device::spring_drive_step(motor, now, command.e_W_V[j],
                                                      command.cancelled_resistance_Ohm[j], h)
                                .end_at(rate[j]);
        }
    }

    const device::DeviceDescription &device_;
    Vector3 rest_rad_;
    Eigen::Index shaken_;
    double omega_;
    double period_s_;
    Watch watch_;
    long periods_ = 0;
    Vector3 current_A_{Vector3::Zero()};
};

/// −τ of all motors per angle of the vibrating one while the law holds the tip at a point, as a
/// phasor [N·m/rad]. After the initial transient, the current's component at ω is weighted by a
/// Hann window, which suppresses all other frequencies.
Eigen::Vector3cd motor_stiffness(const loops::StabilityCase &which, Eigen::Index shaken,
                                 double omega_rad_per_s) {
    constexpr double kSettles_s = 0.05;
    constexpr double kWatched_s = 0.4;
    Eigen::Vector3cd sum = Eigen::Vector3cd::Zero();
    double weights = 0.0;
    const auto correlate = [&](double time_s, const Vector3 &current_A) {
        const double share = (time_s - kSettles_s) / kWatched_s;
        const double weight = share > 0.0 ? 1.0 - std::cos(2.0 * std::numbers::pi * share) : 0.0;
        sum += weight * std::polar(1.0, -omega_rad_per_s * time_s) *
               current_A.cast<std::complex<double>>();
        weights += weight;
    };
    rig::LawOptions law;
    law.device = which.device;
    law.period_s = which.period_s;
    law.rests_at_rad = device::motor_from_joint(which.device.geometry, which.q_rad);
    VibratingRotors rotors(which.device, *law.rests_at_rad, shaken, omega_rad_per_s, which.period_s,
                           correlate);
    rig::LawRig loop(rotors, law,
                     rig::tied_to(device::tip_position_m(which.device.geometry, which.q_rad)),
                     rig::FirstCommand::answers);
    while (rotors.time_s() < kSettles_s + kWatched_s) {
        loop.tick();
    }
    // A cosine of that amplitude has half of it at ω.
    return -2.0 / (weights * VibratingRotors::kAmplitude_rad) *
           control::torque_constants(which.device).cast<std::complex<double>>().cwiseProduct(sum);
}

double measured_deg(const loops::StabilityCase &which, double frequency_hz) {
    Eigen::Matrix2cd per_motor;
    for (Eigen::Index j = 0; j < 2; ++j) {
        per_motor.col(j) = motor_stiffness(which, j + 1, rate_rad_per_s(frequency_hz)).tail<2>();
    }
    const Eigen::Matrix2cd J_inverse =
        loops::Matrix2(loops::planar_jacobian(which.device.geometry, which.q_rad).inverse())
            .cast<std::complex<double>>();
    return kDegreesPerRadian *
           loops::worst_direction_error_rad(J_inverse.transpose() * per_motor * J_inverse);
}

Experiment wrong_direction(const loops::StabilityCase &which) {
    constexpr TriedValues kFrequencies_hz{1.0, 200.0};
    const double alpha =
        control::alpha_bound(device::motor_jacobian(which.device.geometry, which.q_rad),
                             control::relative_stiffness(which.device));
    const loops::PlanarContact contact = loops::planar_contact(
        which.device, control::Tuning{}, which.q_rad, alpha, which.sampling());
    const double predicted_hz = last_that_holds(
        {kFrequencies_hz.holds_at, kFrequencies_hz.fails_at}, kFrequencies_hz.resolution,
        [&](double frequency_hz) {
            return kDegreesPerRadian *
                       loops::worst_direction_error_rad(loops::tip_stiffness(
                           contact, control::MotionMap::transpose, rate_rad_per_s(frequency_hz))) <
                   control::kNoticeable_deg;
        });
    return {
        {kTransposeKinematics, "wrong force direction above", "Hz",
         fmt::format(
             "force of a vibration {:g}° off the worst normal, tuning firm, 1 kHz; λ is {}",
             control::kNoticeable_deg,
             with_unit(std::round(control::Tuning{}.lambda_rad_per_s / (2.0 * std::numbers::pi)),
                       "Hz")),
         predicted_hz},
        kFrequencies_hz,
        [=](double frequency_hz) {
            return measured_deg(which, frequency_hz) < control::kNoticeable_deg;
        }};
}

// The limiter.

/// The law's command at one configuration, passed through the limiter.
class LimitedLaw {
public:
    LimitedLaw(const device::DeviceDescription &device, const Vector3 &q_rad)
        : device_(device), law_(device),
          theta_rad_(device::motor_from_joint(device.geometry, q_rad)) {}

    /// Pressed in by `depth_m`, at rest.
    [[nodiscard]] servo::ActiveLimits pressed(double depth_m, const Vector3 &normal) const {
        const control::Configuration now = law_.configuration(theta_rad_, Vector3::Zero());
        contact::Contact contact;
        contact.touching = true;
        contact.eta = 0.0;
        contact.normal = normal;
        contact.x0_m = now.tip_m + depth_m * normal;
        contact.tangent_projector = Matrix3::Identity() - normal * normal.transpose();
        return active_limits(now, contact);
    }

    /// In free space, one motor turning.
    [[nodiscard]] servo::ActiveLimits turning(double rate_rad_per_s) const {
        const control::Configuration now =
            law_.configuration(theta_rad_, Vector3(0.0, rate_rad_per_s, 0.0));
        contact::Contact contact;
        contact.x0_m = now.tip_m;
        return active_limits(now, contact);
    }

private:
    [[nodiscard]] servo::ActiveLimits active_limits(const control::Configuration &now,
                                                    const contact::Contact &contact) const {
        servo::LimiterInputs inputs{now, servo::limits_of(device_), 1.0, Vector3::Zero(),
                                    control::motors_of_file(device_.motor)};
        for (std::size_t j = 0; j < 3; ++j) {
            inputs.R_hat_limit_Ohm[static_cast<Eigen::Index>(j)] =
                device::WindingGuard(device_.motor[j], device_.amplifier.max_cancelled_Ohm, 1.0)
                    .max_cancelled_Ohm();
        }
        return servo::limited(device_, law_(now, contact, control::Tuning{}, {}).command, inputs)
            .active_limits;
    }

    device::DeviceDescription device_;
    control::HapticLaw law_;
    Vector3 theta_rad_;
};

/// r of the kinematics: the distance of the tip from the base's axis.
double radius_m(const device::PhantomGeometry &geometry, const Vector3 &q_rad) {
    return geometry.upper_arm_m * std::cos(q_rad[1]) + geometry.forearm_m * std::sin(q_rad[2]);
}

/// (29) where l₁ = l₂ = l and N₂ = N₃ = N: the largest singular values of J are r/N₁ and
/// l √(1 + |sin(q₃ − q₂)|)/N.
double bound_of_even_links(const device::PhantomGeometry &geometry, const Vector3 &q_rad) {
    const double N = geometry.transmission_ratio[1];
    const double l_m = geometry.upper_arm_m;
    const double base = radius_m(geometry, q_rad) / geometry.transmission_ratio[0];
    return 1.0 / std::max(base * base,
                          l_m * l_m / (N * N) * (1.0 + std::abs(std::sin(q_rad[2] - q_rad[1]))));
}

/// The smallest residual resistance that the limiter assumes: at the commutator's worst angle.
double worst_dR_Ohm(const device::MotorParameters &motor) {
    return control::Tuning{}.dR_Ohm - motor.commutation_ripple * motor.resistance_Ohm;
}

/// The depth along a normal from which on the limiter reduces the force.
Experiment pressed_deeper(const device::DeviceDescription &device, const Vector3 &q_rad,
                          const Vector3 &normal, const std::string &setting, double predicted_mm) {
    const LimitedLaw law(device, q_rad);
    return {{kMotorMethod, "pressed deeper than", "mm", setting,
             if_links_are_even(device, predicted_mm)},
            {1e-3, 100.0},
            [=](double depth_mm) { return !law.pressed(1e-3 * depth_mm, normal).holds_force(); }};
}

/// Under the transpose map K_x = α k_T K_P/dR in all directions.
Experiment too_much_force(const device::DeviceDescription &device, const Vector3 &q_rad) {
    const device::MotorParameters &motor = device.motor[1];
    const double force_N = servo::kLimiterShare * device.limits.tip_force_N;
    const double predicted_mm = 1e3 * force_N * worst_dR_Ohm(motor) /
                                (bound_of_even_links(device.geometry, q_rad) *
                                 motor.torque_constant_Nm_per_A * control::Tuning{}.K_P_V_per_rad);
    return pressed_deeper(device, q_rad, Vector3::UnitY(),
                          "tuning firm, upwards: 95 % of " +
                              with_unit(device.limits.tip_force_N, "N") +
                              ", where the force saturates",
                          predicted_mm);
}

/// Far out, a sideways push reaches the current limit of the base's motor before the force limit.
Experiment too_much_current(const device::DeviceDescription &device) {
    const Vector3 stretched_rad(0.0, 0.0, 50.0 * kRadiansPerDegree);
    const device::MotorParameters &motor = device.motor[0];
    const double r_m = radius_m(device.geometry, stretched_rad);
    const double lever_m = r_m / device.geometry.transmission_ratio[0];
    const double predicted_mm = 1e3 * servo::kLimiterShare * motor.peak_current_A *
                                worst_dR_Ohm(motor) /
                                (control::Tuning{}.K_P_V_per_rad *
                                 bound_of_even_links(device.geometry, stretched_rad) * lever_m);
    return pressed_deeper(device, stretched_rad, Vector3::UnitX(),
                          "tuning firm, sideways at r " + with_unit(std::round(1e3 * r_m), "mm") +
                              ": 95 % of " + with_unit(motor.peak_current_A, "A"),
                          predicted_mm);
}

/// Free motion is free of force as long as e_W can cancel the back-EMF k_T θ̇.
Experiment too_much_voltage(const device::DeviceDescription &device, const Vector3 &q_rad) {
    const device::MotorParameters &motor = device.motor[1];
    const LimitedLaw law(device, q_rad);
    return {{kMotorMethod, "free motion faster than", "rad/s",
             "e_W reaches the supply of " + with_unit(motor.supply_V, "V"),
             motor.supply_V / motor.torque_constant_Nm_per_A},
            {1.0, 1e4},
            [=](double rate) { return !law.turning(rate).voltage; }};
}

} // namespace

Experiments inverse_experiments(const device::DeviceDescription &device) {
    return {exploding(device), unreachable(device), base_axis(device)};
}

Experiments direction_experiments(const loops::StabilityCase &which) {
    return {wrong_direction(which)};
}

Experiments limiter_experiments(const loops::StabilityCase &which) {
    return {too_much_force(which.device, which.q_rad), too_much_current(which.device),
            too_much_voltage(which.device, which.q_rad)};
}

} // namespace springdrive::limits

#include "engine/lab/loops/rendered_stiffness.h"

#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "device/core/split_delay.h"
#include "engine/control/motion_control.h"
#include "engine/control/velocity_filter.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

namespace springdrive::loops {

namespace {

using Complex = std::complex<double>;

/// k_T/(jωL + R): torque per volt across the winding.
Complex torque_per_volt(const device::MotorParameters &motor, double resistance_Ohm,
                        double omega_rad_per_s) {
    return motor.torque_constant_Nm_per_A /
           Complex(resistance_Ohm, omega_rad_per_s * motor.inductance_H);
}

} // namespace

std::complex<double> analytic_stiffness(const SpringDrive &drive, double omega_rad_per_s) {
    const Complex s(0.0, omega_rad_per_s);
    const double k_T = drive.motor.torque_constant_Nm_per_A;
    const double K_P = drive.tuning.K_P_V_per_rad;
    const double K_D = drive.tuning.K_D_Vs_per_rad;
    const double lambda = drive.tuning.lambda_rad_per_s;
    return torque_per_volt(drive.motor, drive.dR_Ohm(), omega_rad_per_s) * lambda / (s + lambda) *
           ((k_T + K_D + K_P / lambda) * s + K_P + k_T * s * s / lambda);
}

std::complex<double> sampled_stiffness(const SpringDrive &drive, double omega_rad_per_s) {
    DrivenLoad load = DrivenLoad::of(1);
    load.put_behind_spring_drive(0, drive.motor, drive.dR_Ohm());
    const SampledLaw law =
        drift_compensation(load.torque_Nm_per_A, gains_of(drive.tuning),
                           Eigen::MatrixXd::Identity(1, 1), {drive.period_s, drive.delay_periods});
    return motor_stiffness(load, law, omega_rad_per_s)(0, 0);
}

std::complex<double> unmodified_stiffness(const device::MotorParameters &motor,
                                          double omega_rad_per_s) {
    return torque_per_volt(motor, motor.resistance_Ohm, omega_rad_per_s) *
           Complex(0.0, motor.torque_constant_Nm_per_A * omega_rad_per_s);
}

namespace {

StabilityCase whole(StabilityCase which) {
    which.freedom = Freedom::three_motors;
    return which;
}

} // namespace

Complex tip_stiffness(const StabilityCase &which, const Vector3 &direction,
                      double omega_rad_per_s) {
    const StabilityCase all = whole(which);
    const LoopMember without_hand{0, no_hand()};
    const DrivenLoad load = driven_load(all, without_hand);
    const SampledLaw law = sampled_law(all, without_hand);
    const Eigen::MatrixXcd motors = motor_stiffness(load, law, omega_rad_per_s);
    const Vector3 n = direction.normalized();
    const Vector3 theta = device::motor_jacobian(which.device.geometry, which.q_rad).inverse() * n;
    return theta.cast<Complex>().dot(motors * theta.cast<Complex>());
}

Matrix3 felt_at_rest_N_per_m(const StabilityCase &which, const Structure &structure) {
    const StabilityCase all = whole(which);
    const LoopMember without_hand{0, no_hand()};
    const Matrix3 motors =
        motor_stiffness(driven_load(all, without_hand), sampled_law(all, without_hand), 0.0).real();
    const Matrix3 per_tip = device::motor_jacobian(which.device.geometry, which.q_rad).inverse();
    return felt_stiffness_N_per_m(
        per_tip.transpose() * motors * per_tip,
        structural_compliance_m_per_N(which.device, structure, which.q_rad));
}

double inductive_tip_stiffness(const StabilityCase &which, const Vector3 &direction) {
    if (which.drive == device::AmplifierKind::current_drive) {
        return 0.0;
    }
    const Vector3 n = direction.normalized();
    const Vector3 theta = device::motor_jacobian(which.device.geometry, which.q_rad).inverse() * n;
    double stiffness = 0.0;
    for (Eigen::Index i = 0; i < 3; ++i) {
        stiffness +=
            theta[i] * theta[i] *
            device::inductive_stiffness_Nm_per_rad(which.device.motor[static_cast<std::size_t>(i)]);
    }
    return stiffness;
}

double force_of_a_count_N(const StabilityCase &which) {
    const StabilityCase all = whole(which);
    const LoopMember without_hand{0, no_hand()};
    const DrivenLoad load = driven_load(all, without_hand);
    const SampledLaw law = sampled_law(all, without_hand);
    const Matrix3 command =
        which.device.rad_per_count() *
        ((1.0 - law.filter_pole) / law.period_s * law.per_velocity + law.per_position);
    const Matrix3 current_A = sampled_load(load, which.period_s).block<3, 3>(6, 9) * command;
    const Matrix3 J = device::motor_jacobian(which.device.geometry, which.q_rad);
    const Matrix3 force_N = J.transpose().inverse() * load.torque_Nm_per_A.asDiagonal() * current_A;
    return force_N.colwise().norm().maxCoeff();
}

namespace {

using std::numbers::pi;

constexpr long kMinTicks = 1000;
constexpr double kMaxStep_rad = 0.02;           ///< ωh
constexpr double kTimeConstantsToSettle = 14.0; ///< e^(−14) < 1e-6

/// The voltages applied over one period.
struct AppliedVolts {
    double first_V = 0.0;  ///< e_W[k−n−1], for f T
    double second_V = 0.0; ///< e_W[k−n], for the rest
};

/// The servo of one motor: turns each reading into the e_W that is applied from then on.
class LockedServo {
public:
    LockedServo(const SpringDrive &drive, double encoder_quantum_rad)
        : drive_(drive), quantum_rad_(encoder_quantum_rad),
          pole_(control::velocity_filter_pole(drive.tuning.lambda_rad_per_s, drive.period_s)),
          k_T_(Vector3::Constant(drive.motor.torque_constant_Nm_per_A)),
          held_V_(static_cast<std::size_t>(device::split_delay(drive.delay_periods).whole) + 1,
                  0.0) {}

    AppliedVolts tick(double theta_rad) {
        const double read_rad =
            quantum_rad_ > 0.0 ? quantum_rad_ * std::round(theta_rad / quantum_rad_) : theta_rad;
        reading_.theta_rad.setConstant(read_rad);
        reading_.theta_rate_rad_per_s = filter_.update(reading_.theta_rad, pole_, drive_.period_s);
        held_V_.push_back(
            control::drift_compensation_V(k_T_, drive_.tuning, reading_, locked_).x());
        const AppliedVolts applied{held_V_[0], held_V_[1]};
        held_V_.pop_front();
        return applied;
    }

private:
    const SpringDrive &drive_;
    double quantum_rad_;
    double pole_;
    Vector3 k_T_;
    std::deque<double> held_V_;      ///< e_W[k−n−1] and later
    control::VelocityFilter filter_; ///< of three motors with identical motions
    control::Configuration reading_;
    const control::MotorSetPoint locked_{};
};

/// A part of the period in which one e_W is applied.
struct SweepPart {
    double from = 0.0;  ///< in shares of the period
    double share = 1.0; ///< how much of it
    long steps = 0;
    device::WindingStep winding;
    double back_emf_V_per_rad = 0.0;
    Complex correlation_A = 0.0;

    SweepPart(const SpringDrive &drive, double from_share, double its_share, double turn_a_tick)
        : from(from_share), share(its_share),
          steps(std::lround(std::ceil(its_share * turn_a_tick / kMaxStep_rad))) {
        const double h_s = its_share * drive.period_s / static_cast<double>(steps);
        winding = device::winding_step(drive.motor, drive.dR_Ohm(), h_s);
        back_emf_V_per_rad = drive.motor.torque_constant_Nm_per_A / h_s;
    }
};

/// One part for a whole delay, and two that meet at f T for any other.
std::vector<SweepPart> parts_of_period(const SpringDrive &drive, double turn_a_tick) {
    const double f = device::split_delay(drive.delay_periods).fraction;
    std::vector<SweepPart> parts;
    if (f > 0.0) {
        parts.emplace_back(drive, 0.0, f, turn_a_tick);
    }
    parts.emplace_back(drive, f, 1.0 - f, turn_a_tick);
    return parts;
}

/// Ticks until the initial transient has decayed.
long settling_ticks(const SpringDrive &drive) {
    const double slowest_s =
        std::max(drive.motor.inductance_H / drive.dR_Ohm(), 1.0 / drive.tuning.lambda_rad_per_s);
    const double ticks = std::ceil(kTimeConstantsToSettle * slowest_s / drive.period_s);
    return static_cast<long>(ticks) + device::split_delay(drive.delay_periods).held() + 1;
}

} // namespace

SweepWindow sweep_window(double frequency_hz, double period_s) {
    const double periods_a_tick = frequency_hz * period_s;
    const long periods = std::max(1L, std::lround(std::ceil(kMinTicks * periods_a_tick)));
    const long ticks = std::lround(static_cast<double>(periods) / periods_a_tick);
    return {periods, std::max(ticks, 2 * periods + 1)};
}

std::complex<double> measured_stiffness(const SpringDrive &drive, SweepWindow window,
                                        const SweepOptions &options) {
    const double turn_a_tick =
        2.0 * pi * static_cast<double>(window.periods) / static_cast<double>(window.ticks);
    std::vector<SweepPart> parts = parts_of_period(drive, turn_a_tick);
    // e^(jωt) a share of a period after a tick, reduced to one turn, so that its accuracy does not
    // degrade with time.
    const auto phasor = [&](long tick, const SweepPart &part, long step) {
        if (parts.size() == 1) { // equal steps: exact in integers
            const long steps = window.ticks * part.steps;
            const long within = (tick * part.steps + step) % steps * window.periods % steps;
            return std::polar(1.0,
                              2.0 * pi * static_cast<double>(within) / static_cast<double>(steps));
        }
        const long within = tick % window.ticks * window.periods % window.ticks;
        const double share =
            part.from + part.share * static_cast<double>(step) / static_cast<double>(part.steps);
        return std::polar(1.0, turn_a_tick * share + 2.0 * pi * static_cast<double>(within) /
                                                         static_cast<double>(window.ticks));
    };

    LockedServo servo(drive, options.encoder_quantum_rad);
    const long settling = settling_ticks(drive);
    double current_A = 0.0;
    Complex now = phasor(0, parts.front(), 0);
    for (long tick = 0; tick < settling + window.ticks; ++tick) {
        const AppliedVolts applied = servo.tick(options.amplitude_rad * now.imag());
        for (SweepPart &part : parts) {
            const double e_W_V = &part == &parts.back() ? applied.second_V : applied.first_V;
            for (long step = 1; step <= part.steps; ++step) {
                const Complex next = phasor(tick, part, step);
                const double moved_rad = options.amplitude_rad * (next.imag() - now.imag());
                const double u_V = e_W_V - part.back_emf_V_per_rad * moved_rad;
                if (tick >= settling) {
                    const double mean_A =
                        part.winding.mean_decay * current_A + part.winding.mean_gain_A_per_V * u_V;
                    part.correlation_A += mean_A * std::conj(now);
                }
                current_A = part.winding.decay * current_A + part.winding.gain_A_per_V * u_V;
                now = next;
            }
        }
    }
    // The mean current belongs to the middle of its step. A sine is −j as a phasor.
    Complex current_phasor_A = 0.0;
    for (const SweepPart &part : parts) {
        const double half_step_rad =
            0.5 * part.share * turn_a_tick / static_cast<double>(part.steps);
        current_phasor_A +=
            part.correlation_A *
            std::polar(2.0 * part.share / static_cast<double>(window.ticks * part.steps),
                       -half_step_rad);
    }
    const Complex theta_phasor_rad(0.0, -options.amplitude_rad);
    return -drive.motor.torque_constant_Nm_per_A * current_phasor_A / theta_phasor_rad;
}

std::vector<StiffnessPoint> stiffness_sweep(const SpringDrive &drive, const SweepRange &range,
                                            const SweepOptions &options) {
    std::vector<StiffnessPoint> points;
    const double ratio = std::log(range.max_hz / range.min_hz) / (range.points - 1);
    for (int i = 0; i < range.points; ++i) {
        const SweepWindow window = sweep_window(range.min_hz * std::exp(ratio * i), drive.period_s);
        const double f_hz = window.frequency_hz(drive.period_s);
        const double omega_rad_per_s = 2.0 * pi * f_hz;
        points.push_back({f_hz, analytic_stiffness(drive, omega_rad_per_s),
                          sampled_stiffness(drive, omega_rad_per_s),
                          measured_stiffness(drive, window, options)});
    }
    return points;
}

double phase_deg(const std::complex<double> &stiffness) {
    return std::arg(stiffness) * kDegreesPerRadian;
}

Table stiffness_table(const std::vector<StiffnessPoint> &points) {
    Table table = Table::with_columns("freq_hz,analytic_mag,analytic_phase_deg,sampled_mag,"
                                      "sampled_phase_deg,measured_mag,measured_phase_deg",
                                      ".9g");
    for (const StiffnessPoint &point : points) {
        table.rows.push_back(
            {point.frequency_hz, std::abs(point.analytic_Nm_per_rad),
             phase_deg(point.analytic_Nm_per_rad), std::abs(point.sampled_Nm_per_rad),
             phase_deg(point.sampled_Nm_per_rad), std::abs(point.measured_Nm_per_rad),
             phase_deg(point.measured_Nm_per_rad)});
    }
    return table;
}

} // namespace springdrive::loops

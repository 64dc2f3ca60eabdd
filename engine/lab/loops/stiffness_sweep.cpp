#include "engine/lab/loops/stiffness_sweep.h"

#include "base/degrees.h"
#include "device/core/split_delay.h"
#include "engine/control/motion_control.h"
#include "engine/control/velocity_filter.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

namespace springdrive::loops {

namespace {

using Complex = std::complex<double>;
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

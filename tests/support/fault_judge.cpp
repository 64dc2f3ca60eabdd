#include "tests/support/fault_judge.h"

#include "device/core/motor/winding_heat.h"
#include "engine/servo/safety_limits.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::testing {

namespace {

constexpr double kRoundOff = 1e-6; // of a limit
constexpr double kMemory_s = 0.5;  // of the energy observer, safety_monitor.h
constexpr double kVolts_s = 0.02;  // how long e_W may be above its limit, safety_monitor.h

} // namespace

TipAt::TipAt(const device::PhantomGeometry &geometry, const Vector3 &theta_rad)
    : q_rad(theta_rad.array() / geometry.transmission_ratio.array()) {
    const double l1 = geometry.upper_arm_m;
    const double l2 = geometry.forearm_m;
    const double s1 = std::sin(q_rad[0]);
    const double c1 = std::cos(q_rad[0]);
    const double r = l1 * std::cos(q_rad[1]) + l2 * std::sin(q_rad[2]);
    const double r_2 = -l1 * std::sin(q_rad[1]);
    const double r_3 = l2 * std::cos(q_rad[2]);
    tip_m << r * s1, l2 - l2 * std::cos(q_rad[2]) + l1 * std::sin(q_rad[1]), r * c1 - l1;
    J << r * c1, r_2 * s1, r_3 * s1,                           //
        0.0, l1 * std::cos(q_rad[1]), l2 * std::sin(q_rad[2]), //
        -r * s1, r_2 * c1, r_3 * c1;
    J.array().rowwise() /= geometry.transmission_ratio.transpose().array();
}

Vector3 TipAt::force_N(const Vector3 &torque_Nm) const {
    return J.transpose().partialPivLu().solve(torque_Nm);
}

FaultJudge::FaultJudge(const device::DeviceDescription &device, double period_s)
    : device_(device), law_(device), k_T_(control::torque_constants(device)), period_s_(period_s),
      winding_C_(Vector3::Constant(device::kWarmestAir_C)),
      housing_C_(Vector3::Constant(device::kWarmestAir_C)) {}

void FaultJudge::reset() {
    has_energy_ = false;
    generated_J_ = 0.0;
    may_volts_ = 0;
    must_volts_ = 0;
    state_ = servo::SafetyState::waiting;
    is_resetting_board_ = board_has_faults_;
    since_board_reset_s_ = 0.0;
}

servo::TripCause FaultJudge::first_must() const {
    const auto *found = std::find_if(findings_.begin(), findings_.end(),
                                     [](const Finding &finding) { return finding.must; });
    return found == findings_.end() ? servo::TripCause::none
                                    : static_cast<servo::TripCause>(found - findings_.begin());
}

/// @param slack  share of the limit within which either result is correct
void FaultJudge::find(servo::TripCause cause, double measured, double limit, double slack) {
    Finding &finding = findings_[static_cast<std::size_t>(cause)];
    if (!finding.must && (finding.limit == 0.0 || measured > finding.measured)) { // or the first
        finding.measured = measured;
        finding.limit = limit;
    }
    finding.may |= !(measured <= limit * (1.0 - slack));
    finding.must |= !(measured <= limit * (1.0 + slack));
}

void FaultJudge::look_at_link(const device::Measurement &measured,
                              const servo::SafetyLimits &limits) {
    find(servo::TripCause::device_lost, measured.health == device::DeviceHealth::ok ? 0.0 : 1.0,
         0.5, 0.0);
    // A reset gives the board a tenth of a second to clear its faults.
    constexpr double kBoardReset_s = 0.1;
    since_board_reset_s_ += elapsed_s_;
    board_has_faults_ = measured.faults.any();
    is_resetting_board_ = is_resetting_board_ && board_has_faults_ &&
                          since_board_reset_s_ < kBoardReset_s * (1.0 - kRoundOff);
    find(servo::TripCause::board_fault, is_resetting_board_ ? 0.0 : measured.faults.bits, 0.0, 0.0);
    stale_s_ = measured.arrival == device::Arrival::fresh ? 0.0 : stale_s_ + elapsed_s_;
    find(servo::TripCause::stale_measurement, stale_s_, limits.stale_s, kRoundOff);
}

void FaultJudge::look_at_window(const servo::ServoInputs &inputs, const servo::TickTiming &timing,
                                const servo::SafetyLimits &limits) {
    find(servo::TripCause::emergency_stop, inputs.requested_stop > inputs.released_stop ? 1.0 : 0.0,
         0.5, 0.0);
    find(servo::TripCause::missed_deadlines, timing.missed_in_a_row * period_s_, limits.late_s,
         kRoundOff);
    const bool silent = inputs.heartbeat == heartbeat_ && inputs.heartbeat != 0;
    heartbeat_ = inputs.heartbeat;
    silent_s_ = silent ? silent_s_ + elapsed_s_ : 0.0;
    find(servo::TripCause::window_silent, silent_s_, limits.window_silence_s, kRoundOff);
}

/// Peak currents, and the upper estimate of each winding's temperature: the network of
/// winding_heat.h integrated by small Euler steps.
void FaultJudge::look_at_currents(const Vector3 &current_A, const servo::ServoSample &sample) {
    constexpr int kParts = 8;
    const double h = period_s_ / kParts;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const device::MotorParameters &motor = device_.motor[static_cast<std::size_t>(j)];
        find(servo::TripCause::current, std::abs(current_A[j]),
             std::min(motor.peak_current_A, sample.limits.current_A), kRoundOff);
        const device::ThermalParameters &thermal = motor.thermal;
        double worst_A = std::max(std::abs(current_A[j]), std::abs(current_A_[j]));
        if (!std::isfinite(current_A[j]) || !std::isfinite(current_A_[j])) {
            worst_A = motor.peak_current_A;
        }
        const double tolerance =
            motor.resistance_tolerance + device_.current_sensing.gain_tolerance;
        const double R_Ohm = motor.resistance_Ohm * (1.0 + tolerance) *
                             (1.0 + motor.commutation_ripple) *
                             (1.0 + motor.resistance_rise_per_K * (winding_C_[j] - 25.0));
        for (int part = 0; part < kParts; ++part) {
            const double inner_W =
                (winding_C_[j] - housing_C_[j]) / thermal.winding_housing_K_per_W;
            const double outer_W =
                (housing_C_[j] - device::kWarmestAir_C) / thermal.housing_ambient_K_per_W;
            winding_C_[j] += h * (worst_A * worst_A * R_Ohm - inner_W) *
                             thermal.winding_housing_K_per_W / thermal.winding_time_s;
            housing_C_[j] +=
                h * (inner_W - outer_W) * thermal.housing_ambient_K_per_W / thermal.motor_time_s;
        }
        const double limit_C = std::min(thermal.max_winding_C, sample.limits.winding_C);
        constexpr double kSlack_K = 5e-4; // error of the Euler steps
        find(servo::TripCause::winding_temperature, winding_C_[j], limit_C, kSlack_K / limit_C);
    }
    current_A_ = current_A;
}

void FaultJudge::look_at_motion(const TipAt &now, const servo::ServoSample &sample,
                                double since_last_s) {
    if (has_tip_) {
        // A hand cannot move at twice the maximum speed; a displacement below that speed is not an
        // encoder fault.
        const double count_m =
            2.0 * std::numbers::pi / device_.encoder_counts_per_turn * now.J.norm();
        const double way_m = device_.limits.tip_speed_m_per_s * since_last_s;
        const double jump_m = (now.tip_m - tip_m_).norm();
        Finding &finding = findings_[static_cast<std::size_t>(servo::TripCause::encoder_jump)];
        finding = {jump_m > way_m + 2 * count_m, jump_m > 2 * way_m + 5 * count_m, jump_m, way_m};
    }
    tip_m_ = now.tip_m;
    has_tip_ = true;
    find(servo::TripCause::tip_speed, (now.J * rate_rad_per_s_).norm(),
         sample.limits.tip_speed_m_per_s, kRoundOff);
    look_at_stops(now.q_rad, sample.limits.beyond_stops_rad);
}

void FaultJudge::look_at_stops(const Vector3 &q_rad, double limit_rad) {
    const device::JointLimits &stops = device_.joint_limits;
    const double fold_rad = q_rad[2] - q_rad[1];
    double worst_rad =
        std::max(fold_rad - stops.max_q3_minus_q2_rad, stops.min_q3_minus_q2_rad - fold_rad);
    for (Eigen::Index j = 0; j < 3; ++j) {
        worst_rad = std::max({worst_rad, q_rad[j] - stops.max_rad[j], stops.min_rad[j] - q_rad[j]});
    }
    find(servo::TripCause::beyond_stops, std::max(0.0, worst_rad), limit_rad, kRoundOff);
}

/// The definition of safety_monitor.h: ΔG = F̄·Δx + ΔS, decaying over half a second. A spring
/// whose force is limited counts as yielding at constant force.
void FaultJudge::look_at_energy(const TipAt &now, const Vector3 &force_N,
                                const servo::ServoSample &sample) {
    if (state_ != servo::SafetyState::running) {
        has_energy_ = false;
        generated_J_ = 0.0;
        return;
    }
    double stored_J = 0.0;
    if (sample.contact.touching) {
        const Vector3 K_DC = k_T_.cwiseProduct(sample.stiffness_share) *
                             (sample.tuning.K_P_V_per_rad / sample.tuning.dR_Ohm);
        const Vector3 spring_N =
            now.force_N(K_DC.cwiseProduct(sample.theta_Sd_rad - sample.theta_rad));
        const Vector3 stretch_m = sample.contact.x0_m - now.tip_m;
        stored_J = 0.5 * spring_N.dot(stretch_m) * (1.0 - (1.0 - share_) * (1.0 - share_));
    }
    // Energy counted as stored: rises by no more than the hand puts in, falls by no more than it
    // receives.
    double held_J = stored_J;
    if (has_energy_) {
        const double changed_J = 0.0; // the tuning is constant while the observer runs
        const double work_J = 0.5 * (force_N + energy_force_N_).dot(now.tip_m - energy_tip_m_);
        double stretched_J = stored_J - stored_J_ - changed_J;
        stretched_J = work_J > 0.0 ? std::min(0.0, std::max(stretched_J, -work_J))
                                   : std::max(0.0, std::min(stretched_J, -work_J));
        const double before_J = std::max(0.0, held_J_ + changed_J);
        held_J = std::max(0.0, std::min(before_J + stretched_J, stored_J));
        generated_J_ =
            std::max(std::exp(-period_s_ / kMemory_s) * generated_J_ + work_J + held_J - before_J,
                     -sample.limits.generated_energy_J);
    }
    held_J_ = held_J;
    has_energy_ = true;
    energy_tip_m_ = now.tip_m;
    energy_force_N_ = force_N;
    stored_J_ = stored_J;
    find(servo::TripCause::energy, generated_J_, sample.limits.generated_energy_J, 1e-3);
}

void FaultJudge::look_at_voltage(const Vector3 &permissible_V, const servo::ServoSample &sample) {
    const bool felt = state_ == servo::SafetyState::running;
    const double limit_V = std::min(device_.motor[0].supply_V, sample.limits.voltage_V);
    const double worst_V = permissible_V.cwiseAbs().maxCoeff();
    may_volts_ = felt && worst_V > limit_V * (1.0 - kRoundOff) ? may_volts_ + 1 : 0;
    must_volts_ = felt && worst_V > limit_V * (1.0 + kRoundOff) ? must_volts_ + 1 : 0;
    const double slack_s = 1e-3 * period_s_;
    findings_[static_cast<std::size_t>(servo::TripCause::voltage)] = {
        may_volts_ * period_s_ > kVolts_s + slack_s, must_volts_ * period_s_ > kVolts_s + slack_s,
        worst_V, limit_V};
}

/// The share of the requested force that may be passed on, by the rule of command_limiter.h: steady
/// currents, and their force, are within 95 % of their limits.
FaultJudge::Permissible FaultJudge::permissible(const TipAt &now,
                                                const device::DeviceCommand &requested,
                                                const Vector3 &trim_V,
                                                const servo::ServoSample &sample) const {
    const device::MotorParameters &motor = device_.motor[0];
    Vector3 min_Ohm;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const double R_hat_Ohm =
            std::min(requested.cancelled_resistance_Ohm[j],
                     sample.winding[static_cast<std::size_t>(j)].R_hat_limit_Ohm);
        min_Ohm[j] = std::max((1.0 - motor.commutation_ripple) * motor.resistance_Ohm - R_hat_Ohm,
                              device::kMinResidualShare * motor.resistance_Ohm);
    }
    const Vector3 &N = device_.geometry.transmission_ratio;
    const Vector3 edge_Nm =
        servo::edge_torque_Nm(device_, now.q_rad, rate_rad_per_s_.cwiseQuotient(N))
            .cwiseQuotient(N);
    const Vector3 back_emf_V = k_T_.cwiseProduct(rate_rad_per_s_) + trim_V;
    const Vector3 steady_current_A =
        (requested.e_W_V - back_emf_V).cwiseQuotient(min_Ohm) + edge_Nm.cwiseQuotient(k_T_);
    const double force_N = now.force_N(k_T_.cwiseProduct(steady_current_A)).norm();
    const double max_A = std::min(motor.peak_current_A, sample.limits.current_A);
    const double share = std::min({1.0, 0.95 * max_A / steady_current_A.cwiseAbs().maxCoeff(),
                                   0.95 * sample.limits.tip_force_N / force_N});
    return {share, back_emf_V + share * steady_current_A.cwiseProduct(min_Ohm)};
}

void FaultJudge::look(const device::Measurement &measured, const servo::ServoInputs &inputs,
                      const servo::TickTiming &timing, const servo::ServoSample &sample) {
    findings_ = {};
    const std::uint64_t period = period_ + 1 + timing.missed_deadlines;
    elapsed_s_ = static_cast<double>(period - period_) * period_s_;
    period_ = period;
    const servo::SafetyLimits limits = servo::lowered(servo::limits_of(device_), inputs.limits);
    look_at_window(inputs, timing, limits);
    look_at_link(measured, limits);
    if (measured.health == device::DeviceHealth::lost ||
        measured.arrival == device::Arrival::repeated ||
        measured.arrival == device::Arrival::corrupt ||
        measured.arrival == device::Arrival::absent) {
        return; // no information about the rest
    }
    find(servo::TripCause::not_finite, measured.current_A.allFinite() ? 0.0 : 1.0, 0.5, 0.0);

    const double rad_per_count = 2.0 * std::numbers::pi / device_.encoder_counts_per_turn;
    const Vector3 theta_rad =
        rad_per_count * Vector3(measured.counts[0], measured.counts[1], measured.counts[2]);
    const double since_last_s = static_cast<double>(period - told_period_) * period_s_;
    told_period_ = period;
    const double a = std::exp(-sample.tuning.lambda_rad_per_s * since_last_s);
    if (has_previous_) {
        rate_rad_per_s_ = a * rate_rad_per_s_ + (1.0 - a) * (theta_rad - theta_rad_) / since_last_s;
    }
    theta_rad_ = theta_rad;
    has_previous_ = true;

    const TipAt now(device_.geometry, theta_rad);
    const Vector3 force_N = now.force_N(k_T_.cwiseProduct(measured.current_A));
    look_at_currents(measured.current_A, sample);
    find(servo::TripCause::tip_force, force_N.norm(), sample.limits.tip_force_N, kRoundOff);
    look_at_motion(now, sample, since_last_s);
    look_at_energy(now, force_N, sample);
    const control::LawOutcome found =
        law_(law_.configuration(theta_rad, rate_rad_per_s_), sample.contact, sample.tuning,
             {sample.global_alpha_rad2_per_m2}, sample.motor, sample.lag_s);
    device::DeviceCommand requested = found.command;
    requested.e_W_V += sample.transfer_offset_V;
    const Permissible passes = permissible(now, requested, found.trim_V, sample);
    look_at_voltage(passes.e_W_V, sample);
    share_ = passes.share;
    state_ = sample.safety.state;
}

} // namespace springdrive::testing

#include "device/simulated/simulated_phantom.h"

#include "device/core/phantom/kinematics.h"
#include "device/simulated/brushes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace springdrive::simulated {

namespace {

/// Rate at which a hand follows its visual target: the corner frequency of the filter behind
/// `set_hand_target`, which also smooths the steps of a 60 Hz mouse.
constexpr double kHandReachRate = 40.0; // rad/s

/// Time constant with which a residual twist fades: slow, compared with any motion of a rotor.
constexpr double kFading_s = 0.2;

Vector3 limited(const Vector3 &vector, double max_norm) {
    const double norm = vector.norm();
    return norm > max_norm ? Vector3(vector * (max_norm / norm)) : vector;
}

} // namespace

SimulatedPhantom::SimulatedPhantom(const device::DeviceDescription &description,
                                   const SimulationOptions &options, const Vector3 &start_tip_m)
    : description_(simulated_description(description, options)), options_(options),
      parts_(plant_parts(description, options)), requested_parts_(parts_),
      delay_periods_(options.delay_periods),
      hand_target_(options.path ? options.path->points().back().position_m : start_tip_m),
      path_(std::exchange(options_.path, {})), follows_path_(path_.has_value()),
      temperature_(parts_.temperature), converter_{CurrentConverter(3 * options.device_seed),
                                                   CurrentConverter(3 * options.device_seed + 1),
                                                   CurrentConverter(3 * options.device_seed + 2)} {
    requested_ = options_;
    linkage_.q_rad = start_angles_rad(description, options, start_tip_m);
    truth_.tip_m = start_tip_m;
    truth_.hand_target_m = start_tip_m;
    hand_.position_m = start_tip_m;
    pull_target_ = hand_;
    note_linkage(linkage_); // where the cables, if any, are without load
    activate(parts_);
    counts_per_rad_ = 1.0 / description_.rad_per_count();
    warm_windings();
}

/// Activates `parts` at the present pose of linkage and tip.
void SimulatedPhantom::activate(const PlantParts &parts) noexcept {
    parts_ = parts;
    parts_.linkage.outward = {std::sin(linkage_.q_rad[0]), 0.0, std::cos(linkage_.q_rad[0])};
    first_joint_ = parts_.linkage.planar ? 1 : 0;
    if (parts_.cables) {
        connect_rotors();
    } else if (free_rotors_) {
        release_rotors();
    }
    if (parts_.tip_structure) {
        connect_tip();
    } else if (free_tip_) {
        free_tip_.reset();
        note_rigid_tip();
    }
}

/// Rotors and linkage keep their angles and rates. A cable that becomes stiffer keeps its torque,
/// which costs energy; at the same twist it would gain some.
void SimulatedPhantom::connect_rotors() noexcept {
    FreeRotors rotors;
    for (std::size_t motor = 0; motor < rotors.size(); ++motor) {
        const auto j = static_cast<Eigen::Index>(motor);
        FreeRotor &rotor = rotors[motor];
        rotor.cable = (*parts_.cables)[motor];
        rotor.inertia_kg_m2 = parts_.motor[motor].rotor_inertia_kg_m2;
        rotor.rate_rad_per_s = truth_.theta_rate_rad_per_s[j];
        if (free_rotors_) {
            const FreeRotor &before = (*free_rotors_)[motor];
            rotor.twist_rad =
                before.twist_rad *
                std::min(1.0, before.cable.stiffness_Nm_per_rad / rotor.cable.stiffness_Nm_per_rad);
            residual_twist_rad_[j] += before.twist_rad - rotor.twist_rad;
        }
    }
    free_rotors_ = rotors;
}

/// The rotors become part of the linkage: of angles nothing changes, and with both momenta
///
///   (M + N² J_m) q̇ = M q̇₀ + N J_m θ̇₀
///
/// so that the energy of twist and of relative motion is lost, and none is gained.
void SimulatedPhantom::release_rotors() noexcept {
    for (Eigen::Index j = 0; j < 3; ++j) {
        residual_twist_rad_[j] += (*free_rotors_)[static_cast<std::size_t>(j)].twist_rad;
    }
    free_rotors_.reset();
    LinkageState joined = linkage_;
    if (parts_.linkage.has_mass) {
        const Matrix3 links = device::mass_matrix(parts_.linkage.moments, linkage_.q_rad);
        Matrix3 together = links;
        together.diagonal() += parts_.linkage.rotor_kg_m2;
        const Vector3 rotors = parts_.linkage.rotor_kg_m2.cwiseProduct(
            device::joint_from_motor(description_.geometry, truth_.theta_rate_rad_per_s));
        joined.rate_rad_per_s =
            solve_definite<3>(together, links * linkage_.rate_rad_per_s + rotors);
    }
    note_linkage(joined);
    if (!free_tip_) {
        note_rigid_tip();
    }
}

/// The tip keeps its place and velocity, unless the structure becomes stiffer: as cables do.
void SimulatedPhantom::connect_tip() noexcept {
    const device::StructuralCompliance &structure = *parts_.tip_structure;
    if (free_tip_ && structure.stiffness_N_per_m > free_tip_->structure.stiffness_N_per_m) {
        const Vector3 end_m = linkage_end_m();
        truth_.tip_m = end_m + free_tip_->structure.stiffness_N_per_m /
                                   structure.stiffness_N_per_m * (truth_.tip_m - end_m);
    }
    free_tip_ = FreeTip{structure, description_.inertia.tip_load_kg + parts_.hand.mass_kg,
                        truth_.tip_m, truth_.tip_velocity_m_per_s};
}

void SimulatedPhantom::simulate_as(const SimulationOptions &options) {
    SimulationOptions requested = options_;
    requested.dynamics = options.dynamics;
    requested.effects = options.effects;
    requested.planar = options.planar;
    requested.longest_step_s = options.longest_step_s;
    requested.delay_periods = options.delay_periods;
    requested.hand = options.hand;
    PlantParts parts = plant_parts(description_, requested);
    parts.number = ++newest_parts_;
    requested_parts_.publish(parts);
    delay_periods_ = options.delay_periods;
    requested_ = requested;
}

void SimulatedPhantom::hold_with(const device::HandParameters &hand) {
    SimulationOptions requested = requested_;
    requested.hand = hand;
    simulate_as(requested);
}

void SimulatedPhantom::follow(HandPath path) {
    hand_target_.publish(path.points().back().position_m);
    path_ = std::move(path);
    path_start_s_ = truth_.time_s;
    follows_path_ = true;
}

void SimulatedPhantom::take_over(const PlantParts &requested) noexcept {
    const bool was_planar = parts_.linkage.planar;
    PlantParts parts = requested;
    parts.linkage.planar = requested.linkage.planar && was_planar;
    // Otherwise a stop that the linkage is already beyond would throw it back.
    parts.linkage.stops =
        requested.linkage.stops && description_.joint_limits.allow(linkage_.q_rad);
    activate(parts);
}

void SimulatedPhantom::write(const device::DeviceCommand &command) noexcept {
    written_ = {command.is_finite() ? command : device::DeviceCommand::braking(), Vector3::Zero()};
}

void SimulatedPhantom::write_current(const Vector3 &current_A) noexcept {
    written_ = {device::DeviceCommand::braking(),
                current_A.allFinite() ? current_A : Vector3::Zero()};
}

device::Measurement SimulatedPhantom::advance(const PlantCommand &command) noexcept {
    if (options_.amplifier == device::AmplifierKind::current_drive) {
        write_current(command.current_A);
    } else {
        write(command.spring_drive);
    }
    return read();
}

device::Measurement SimulatedPhantom::read() noexcept {
    if (const PlantParts &requested = requested_parts_.latest();
        requested.number != parts_.number) {
        take_over(requested);
    } else if (parts_.effects.joint_limits && !parts_.linkage.stops) {
        parts_.linkage.stops = description_.joint_limits.allow(linkage_.q_rad);
    }
    std::shift_right(pending_.begin(), pending_.end(), 1);
    pending_.front() = connected_ ? written_ : PlantCommand{device::DeviceCommand::braking(), {}};
    const auto whole = static_cast<std::size_t>(parts_.delay_periods);
    const double fraction = parts_.delay_periods - static_cast<double>(whole);
    const double period_s = options_.servo_period_s;
    residual_twist_rad_ /= 1.0 + period_s / kFading_s;
    Vector3 impulse = Vector3::Zero();
    if (fraction > 0.0) {
        impulse = run(pending_[whole + 1], fraction * period_s);
        impulse += run(pending_[whole], (1.0 - fraction) * period_s);
    } else {
        impulse = run(pending_[whole], period_s);
    }
    truth_.hand_force_N = impulse / period_s;
    warm_windings();
    ++periods_;
    return measurement();
}

double SimulatedPhantom::clock_s() const noexcept {
    return clock_base_s_ +
           static_cast<double>(periods_ - clock_base_periods_) * options_.servo_period_s;
}

device::Measurement SimulatedPhantom::measurement() noexcept {
    device::Measurement measured;
    for (std::size_t motor = 0; motor < 3; ++motor) {
        const auto j = static_cast<Eigen::Index>(motor);
        measured.counts[motor] = static_cast<std::int32_t>(
            std::lround((truth_.theta_rad[j] - count_zero_rad_[j]) * counts_per_rad_));
        measured.current_A[j] =
            converter_[motor].reading_A(parts_.own.motor[motor].sensing, truth_.current_A[j]);
    }
    measured.number = periods_;
    measured.time_s = clock_s();
    measured.zeroing = is_zeroed_ ? static_cast<std::uint8_t>(1 + zeroings_) : std::uint8_t{0};
    if (!connected_) {
        measured.arrival = device::Arrival::absent;
        measured.health = device::DeviceHealth::lost;
    }
    return measured;
}

void SimulatedPhantom::set_period(double period_s) {
    SimulationOptions requested = options_;
    requested.servo_period_s = period_s;
    check_options(description_, requested);
    clock_base_s_ = clock_s();
    clock_base_periods_ = periods_;
    options_.servo_period_s = period_s;
    for (device::WindingTemperature &motor : temperature_) {
        motor.set_period(period_s);
    }
}

void SimulatedPhantom::zero(const Vector3 &theta_rad) {
    count_zero_rad_ = truth_.theta_rad - theta_rad;
    zeroings_ = static_cast<std::uint8_t>((zeroings_ + 1) % 16);
    is_zeroed_ = true;
}

/// A board that was just connected counts from the rotors' present angles.
void SimulatedPhantom::reconnect() {
    connected_ = true;
    written_ = {device::DeviceCommand::braking(), Vector3::Zero()};
    zero(Vector3::Zero());
    is_zeroed_ = false;
}

/// Runs the plant with a constant command; returns the hand's impulse on the tip [N·s].
Vector3 SimulatedPhantom::run(const PlantCommand &command, double duration_s) noexcept {
    constexpr double kRoundOff = 1e-9; // no extra step due to it
    const int steps =
        std::max(1, static_cast<int>(std::ceil(duration_s / parts_.longest_step_s - kRoundOff)));
    const double h = duration_s / steps;
    Vector3 impulse = Vector3::Zero();
    for (int i = 0; i < steps; ++i) {
        impulse += h * step(command, h);
    }
    return impulse;
}

double SimulatedPhantom::stored_energy_J() const {
    double energy =
        parts_.linkage.kinetic_energy_J(linkage_) + parts_.linkage.potential_energy_J(linkage_);
    for (std::size_t j = 0; j < 3; ++j) {
        const double current_A = truth_.current_A[static_cast<Eigen::Index>(j)];
        energy += 0.5 * parts_.motor[j].inductance_H * current_A * current_A;
    }
    if (free_rotors_) {
        for (const FreeRotor &rotor : *free_rotors_) {
            energy += rotor.energy_J();
        }
    }
    if (free_tip_) {
        energy += free_tip_->energy_J(linkage_end_m());
        if (parts_.effects.gravity) {
            energy +=
                description_.inertia.tip_load_kg * device::kGravity_m_per_s2 * truth_.tip_m.y();
        }
    }
    return energy;
}

void SimulatedPhantom::set_in_motion(const Vector3 &q_rate_rad_per_s, const Vector3 &current_A) {
    linkage_.rate_rad_per_s = q_rate_rad_per_s;
    truth_.current_A = current_A;
    linkage_.rate_rad_per_s.head(first_joint_).setZero();
    truth_.current_A.head(first_joint_).setZero();
    for (std::size_t j = 0; free_rotors_ && j < 3; ++j) {
        const auto index = static_cast<Eigen::Index>(j);
        (*free_rotors_)[j].rate_rad_per_s =
            description_.geometry.transmission_ratio[index] * linkage_.rate_rad_per_s[index];
    }
    note_linkage(linkage_);
    truth_.tip_velocity_m_per_s =
        device::joint_jacobian(description_.geometry, linkage_.q_rad) * linkage_.rate_rad_per_s;
    if (free_tip_) {
        free_tip_->velocity_m_per_s = truth_.tip_velocity_m_per_s;
    }
}

void SimulatedPhantom::note_linkage(const LinkageState &linkage) noexcept {
    linkage_ = linkage;
    truth_.q_rad = linkage.q_rad;
    truth_.q_rate_rad_per_s = linkage.rate_rad_per_s;
    truth_.theta_rad =
        device::motor_from_joint(description_.geometry, linkage.q_rad) + residual_twist_rad_;
    truth_.theta_rate_rad_per_s =
        device::motor_from_joint(description_.geometry, linkage.rate_rad_per_s);
    for (std::size_t j = 0; free_rotors_ && j < 3; ++j) {
        const auto index = static_cast<Eigen::Index>(j);
        truth_.theta_rad[index] += (*free_rotors_)[j].twist_rad;
        truth_.theta_rate_rad_per_s[index] = (*free_rotors_)[j].rate_rad_per_s;
    }
}

/// Sets the tip's state to that of the linkage's end.
void SimulatedPhantom::note_rigid_tip() noexcept {
    const device::TipPlace place = device::tip_place(description_.geometry, linkage_.q_rad);
    truth_.tip_m = place.tip_m;
    truth_.tip_velocity_m_per_s = place.jacobian_m_per_rad * linkage_.rate_rad_per_s;
}

/// R and k_T at an angle, with the present temperatures.
void SimulatedPhantom::set_angle_dependent(Eigen::Index j, double theta_rad) noexcept {
    const auto index = static_cast<std::size_t>(j);
    const device::MotorParameters &motor = parts_.motor[index];
    const device::WindingTemperature &temperature = temperature_[index];
    truth_.resistance_Ohm[j] =
        device::winding_resistance_Ohm(motor, temperature.winding_C(), theta_rad);
    double k_T = motor.torque_constant_Nm_per_A *
                 (1.0 - motor.torque_constant_fall_per_K *
                            (temperature.housing_C() - device::kReferenceTemperature_C));
    if (const SampledMotor &own = parts_.own.motor[index]; own.torque_ripple != 0.0) {
        k_T *= 1.0 + own.torque_ripple * std::cos(motor.commutator_segments * theta_rad +
                                                  own.torque_ripple_phase_rad);
    }
    truth_.torque_constant_Nm_per_A[j] = k_T;
}

/// Updates temperatures from the heat of the last period and the brushes' film from its current,
/// and what depends on them.
void SimulatedPhantom::warm_windings() noexcept {
    for (Eigen::Index j = 0; j < 3; ++j) {
        device::WindingTemperature &motor = temperature_[static_cast<std::size_t>(j)];
        const SampledMotor &own = parts_.own.motor[static_cast<std::size_t>(j)];
        carried_A_[j] += options_.servo_period_s / (own.brush_film_s + options_.servo_period_s) *
                         (std::abs(truth_.current_A[j]) - carried_A_[j]);
        truth_.brush_current_A[j] =
            own.brush_current_A +
            film_share(carried_A_[j]) * (own.carried_brush_current_A - own.brush_current_A);
        if (parts_.effects.winding_heat) {
            motor.update(heat_J_[j] / options_.servo_period_s);
        }
        truth_.winding_C[j] = motor.winding_C();
        truth_.housing_C[j] = motor.housing_C();
        set_angle_dependent(j, truth_.theta_rad[j]);
    }
    heat_J_.setZero();
}

void SimulatedPhantom::move_hand_target(double h) noexcept {
    const double middle_s = truth_.time_s + 0.5 * h;
    if (follows_path_) {
        hand_ = path_->at(middle_s - path_start_s_);
        follows_path_ = middle_s - path_start_s_ <= path_->end_s();
    } else {
        // Critically damped, semi-implicit: stable for any h below 1/rate.
        const Vector3 gap = hand_target_.latest() - hand_.position_m;
        hand_.velocity_m_per_s +=
            h * kHandReachRate * (kHandReachRate * gap - 2.0 * hand_.velocity_m_per_s);
        hand_.velocity_m_per_s = limited(hand_.velocity_m_per_s, parts_.hand.max_speed_m_per_s);
        hand_.position_m += h * hand_.velocity_m_per_s;
    }
    pull_target_ = hand_;
    const HandStimulus &stimulus = stimulus_.latest();
    if (stimulus.number != stimulus_number_) {
        stimulus_number_ = stimulus.number;
        stimulus_start_s_ = truth_.time_s;
    }
    if (stimulus_number_ != 0) {
        const HandTarget offset = offset_of(stimulus, middle_s - stimulus_start_s_);
        pull_target_.position_m += offset.position_m;
        pull_target_.velocity_m_per_s += offset.velocity_m_per_s;
    }
    truth_.hand_target_m = pull_target_.position_m;
}

SimulatedPhantom::CurrentSteps SimulatedPhantom::drive(const PlantCommand &command,
                                                       double h) noexcept {
    CurrentSteps steps;
    for (Eigen::Index j = first_joint_; j < 3; ++j) {
        steps[static_cast<std::size_t>(j)] = drive_motor(j, command, h);
    }
    return steps;
}

device::CurrentStep SimulatedPhantom::drive_motor(Eigen::Index j, const PlantCommand &command,
                                                  double h) noexcept {
    const SampledMotor &own = parts_.own.motor[static_cast<std::size_t>(j)];
    // At the sub-step's midpoint, so that the commutator's ripples are second order, too.
    set_angle_dependent(j, truth_.theta_rad[j] + 0.5 * h * truth_.theta_rate_rad_per_s[j]);
    device::MotorParameters motor = parts_.motor[static_cast<std::size_t>(j)];
    motor.torque_constant_Nm_per_A = truth_.torque_constant_Nm_per_A[j];
    device::DriveState now{truth_.resistance_Ohm[j], truth_.current_A[j],
                           truth_.theta_rate_rad_per_s[j], parts_.effects.amplifier_limits};
    const double brush_V = own.brush_voltage_V;
    const double brush_A = truth_.brush_current_A[j];
    const bool at_once = parts_.dynamics != PlantDynamics::electromechanical;
    if (options_.amplifier == device::AmplifierKind::current_drive) {
        const double bandwidth_rad_per_s =
            2.0 * std::numbers::pi * description_.amplifier.current_bandwidth_hz;
        const auto driven = [&] {
            return at_once ? device::current_drive_at_once(motor, now, command.current_A[j])
                           : device::current_drive_step(motor, now, command.current_A[j],
                                                        bandwidth_rad_per_s, h);
        };
        // The brushes matter only where the supply does not suffice; then each iteration leaves a
        // share V_b/(R i) of the error.
        for (int i = 0; i < 3 && brush_V > 0.0 && now.limited; ++i) {
            const double mean_A = driven().mean_at(now.rate_rad_per_s);
            now.resistance_Ohm =
                truth_.resistance_Ohm[j] + brush_resistance_Ohm(brush_V, brush_A, mean_A);
        }
        return driven();
    }
    const device::DeviceCommand &spring = command.spring_drive;
    if (spring.mode == device::CommandMode::open) {
        return {}; // no current at any speed
    }
    const bool drives = spring.mode == device::CommandMode::drive;
    const double set_Ohm = std::clamp(drives ? spring.cancelled_resistance_Ohm[j] : 0.0, 0.0,
                                      description_.amplifier.max_cancelled_Ohm);
    // (6) with the current that the amplifier's sensor reads.
    const SensorError &sensor = own.sensing.amplifier;
    const double cancelled_Ohm = sensor.gain * set_Ohm;
    const double e_W_V = (drives ? spring.e_W_V[j] : 0.0) + set_Ohm * sensor.offset_A;
    if (brush_V > 0.0) {
        now.resistance_Ohm += brush_resistance_Ohm(
            brush_V, brush_A,
            mean_behind_brushes_A(brush_V, brush_A, motor, now, e_W_V, cancelled_Ohm, h));
    }
    return at_once ? device::spring_drive_at_once(motor, now, e_W_V, cancelled_Ohm)
                   : device::spring_drive_step(motor, now, e_W_V, cancelled_Ohm, h);
}

/// Of a winding, on a shaft that its motor turns `gear` times as fast.
RateTorque SimulatedPhantom::drive_torque(const CurrentSteps &drive, Eigen::Index j,
                                          double gear) const noexcept {
    const device::CurrentStep &current = drive[static_cast<std::size_t>(j)];
    const double k_T = truth_.torque_constant_Nm_per_A[j];
    return {gear * k_T * current.mean_A, -gear * gear * k_T * current.mean_As_per_rad};
}

LinkageLoad SimulatedPhantom::load(const CurrentSteps &drive, const VelocityLoad &tip,
                                   double h) const noexcept {
    LinkageLoad load;
    load.tip_force_N = tip.force_N;
    load.tip_damping_Ns_per_m = tip.damping_Ns_per_m;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const double N = description_.geometry.transmission_ratio[j];
        RateTorque motor = drive_torque(drive, j, N);
        if (free_rotors_) {
            const FreeRotor &rotor = (*free_rotors_)[static_cast<std::size_t>(j)];
            motor = rotor.at_joint(drive_torque(drive, j, 1.0), h);
            motor = {N * motor.torque_Nm, N * N * motor.damping_Nms_per_rad};
        }
        load.torque_Nm[j] = motor.torque_Nm;
        load.damping_Nms_per_rad[j] =
            motor.damping_Nms_per_rad +
            (parts_.effects.viscous_friction ? description_.friction.viscous_Nms_per_rad : 0.0);
    }
    return load;
}

/// The hand's spring acts with its stretch at the middle of the step, so h/2 times its stiffness
/// adds to the damping; at its maximum force it has no stiffness.
VelocityLoad SimulatedPhantom::hand_load(double h) const noexcept {
    const device::HandParameters &hand = parts_.hand;
    const Vector3 pull = hand.stiffness_N_per_m * (pull_target_.position_m - truth_.tip_m);
    const bool saturated = pull.norm() > hand.max_force_N;
    return {limited(pull, hand.max_force_N) + hand.damping_Ns_per_m * pull_target_.velocity_m_per_s,
            hand.damping_Ns_per_m + (saturated ? 0.0 : 0.5 * h * hand.stiffness_N_per_m)};
}

/// A free tip carries the tip load's weight; for a rigid one it is part of the linkage's moments.
VelocityLoad SimulatedPhantom::with_weight(const VelocityLoad &hand) const noexcept {
    const double weight_N =
        parts_.effects.gravity ? description_.inertia.tip_load_kg * device::kGravity_m_per_s2 : 0.0;
    return {hand.force_N - weight_N * Vector3::UnitY(), hand.damping_Ns_per_m};
}

Vector3 SimulatedPhantom::linkage_end_m() const noexcept {
    return device::tip_position_m(description_.geometry, linkage_.q_rad);
}

SimulatedPhantom::RotorMotion SimulatedPhantom::settle_rotors(const CurrentSteps &drive,
                                                              const LinkageMotion &motion,
                                                              double h) noexcept {
    const device::PhantomGeometry &geometry = description_.geometry;
    RotorMotion rotors{device::motor_from_joint(geometry, motion.mean_rate_rad_per_s),
                       device::motor_from_joint(geometry, motion.after.rate_rad_per_s)};
    for (Eigen::Index j = first_joint_; free_rotors_ && j < 3; ++j) {
        FreeRotor &rotor = (*free_rotors_)[static_cast<std::size_t>(j)];
        rotors.mean_rate_rad_per_s[j] =
            rotor.settle(drive_torque(drive, j, 1.0), rotors.mean_rate_rad_per_s[j], h);
        rotors.end_rate_rad_per_s[j] = rotor.rate_rad_per_s;
    }
    return rotors;
}

void SimulatedPhantom::settle_currents(const CurrentSteps &drive, const RotorMotion &rotors,
                                       double h) noexcept {
    const bool at_once = parts_.dynamics != PlantDynamics::electromechanical;
    for (Eigen::Index j = first_joint_; j < 3; ++j) {
        const device::CurrentStep &current = drive[static_cast<std::size_t>(j)];
        const double mean_rate = rotors.mean_rate_rad_per_s[j];
        const double end_rate = at_once ? rotors.end_rate_rad_per_s[j] : mean_rate;
        // i² averaged as if i were linear over the step; a current without inductance may jump at
        // the start of the step.
        const double after_A = current.end_at(end_rate);
        const double before_A =
            at_once ? 2.0 * current.mean_at(mean_rate) - after_A : truth_.current_A[j];
        truth_.current_A[j] = after_A;
        heat_J_[j] += h * truth_.resistance_Ohm[j] *
                      (before_A * before_A + before_A * after_A + after_A * after_A) / 3.0;
    }
}

void SimulatedPhantom::settle_tip(const LinkageMotion &motion, const VelocityLoad &hand,
                                  const Vector3 &linkage_end_before_m, double h) noexcept {
    if (free_tip_) {
        free_tip_->settle(with_weight(hand), linkage_end_before_m, motion.mean_tip_velocity_m_per_s,
                          h);
        truth_.tip_m = free_tip_->position_m;
        truth_.tip_velocity_m_per_s = free_tip_->velocity_m_per_s;
        return;
    }
    note_rigid_tip();
}

/// One sub-step; returns the hand's force on the tip, its mean over the sub-step [N].
Vector3 SimulatedPhantom::step(const PlantCommand &command, double h) noexcept {
    move_hand_target(h);
    const VelocityLoad hand = hand_load(h);
    const CurrentSteps currents = drive(command, h);
    const Vector3 end_before_m = free_tip_ ? linkage_end_m() : truth_.tip_m;
    const VelocityLoad at_linkage =
        free_tip_ ? free_tip_->at_linkage(with_weight(hand), end_before_m, h) : hand;
    const LinkageMotion motion =
        linkage_step(parts_.linkage, linkage_, load(currents, at_linkage, h), h, friction_mode_);

    settle_currents(currents, settle_rotors(currents, motion, h), h);
    const Vector3 tip_before_m = truth_.tip_m;
    const Vector3 velocity_before = truth_.tip_velocity_m_per_s;
    note_linkage(motion.after);
    settle_tip(motion, hand, end_before_m, h);
    truth_.time_s += h;

    // Force of the hand's spring and damper, minus that which accelerates its own mass.
    const Vector3 mean_velocity = (truth_.tip_m - tip_before_m) / h;
    const Vector3 acceleration = (truth_.tip_velocity_m_per_s - velocity_before) / h;
    return hand.force_N - hand.damping_Ns_per_m * mean_velocity -
           parts_.hand.mass_kg * acceleration;
}

} // namespace springdrive::simulated

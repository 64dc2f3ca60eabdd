#include "engine/commissioning/calibration_run.h"

#include "base/assertions.h"
#include "base/input_error.h"
#include "device/core/device_file.h"
#include "device/core/motor/winding_heat.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>
#include <utility>

namespace springdrive::commissioning {

namespace {

using servo::SafetyState;

constexpr double kPeriod_s = 1.0 / CalibrationRun::kRate_hz;

/// At the start, for the board to clear latched faults.
constexpr int kResetting_ticks = 200;
/// Without rest of the tip, in which the gains could ramp up.
constexpr int kMaxStart_ticks = 60'000;

/// At the end, for a board to report that it brakes.
constexpr int kBraking_ticks = 20;

/// Of the three drags [Hz]: no two of them, nor a hand's motion, stay in step.
constexpr std::array<double, 3> kDrag_hz{0.9, 1.1, 1.3};
/// I₀ as a share of I.
constexpr double kLowLevel = 0.3;
/// ω, δ and τ: from this rate of the rotor on, or after this way, the drag is whole. As a damper it
/// is then well below what a rotor's inertia allows at a delay of some periods.
constexpr double kWholeDrag_rad_per_s = 20.0;
constexpr double kWholeDrag_rad = 0.5;
constexpr double kFading_s = 0.5;
/// How fast the voltage follows that a current takes beside dR, once the drag is nearly whole.
constexpr double kFollowing_s = 0.3;
constexpr double kNearlyWhole = 0.9;

/// The standard deviations of R and of the ripple that end a calibration, and those that are good
/// enough if nothing more is learned, as shares of R. Of an R that changes with its brushes' film
/// not more can be known than that; a thermometer leaves as much.
constexpr double kRequested = 1e-3;
constexpr double kRequestedRipple = 5e-4;
constexpr double kEnough = 8e-3;
constexpr double kEnoughRipple = 2e-3;
/// A deviation of V_b is one of R at this current, between the levels [A].
constexpr double kBetweenLevels_A = 0.5;
/// Estimates that differ by more than so many deviations contradict each other; and by what the
/// observer does not know: of R, half or twice the way of heat from the winding, and of V_b, i_b.
constexpr double kContradiction = 4.0;
constexpr double kUnknownHeat = 0.005;
constexpr double kUnknownBrush = 0.02;
/// Between estimates of V_b.
constexpr int kFit_ticks = 1000;
/// So long without progress, and nothing more is learned.
constexpr int kNoGain_ticks = 20'000;
constexpr double kGain = 0.01;

/// Which joint turns which motor, for people.
constexpr std::array<const char *, 3> kMotions{"swing the stylus to the left and to the right",
                                               "raise and lower the stylus",
                                               "push the stylus away from you and pull it back"};

bool is_known_enough(const device::MotorCalibration &motor) {
    const double enough_Ohm = kEnough * motor.resistance_Ohm;
    return motor.brush_deviation_V > 0.0 && motor.resistance_deviation_Ohm <= enough_Ohm &&
           motor.brush_deviation_V <= enough_Ohm * kBetweenLevels_A &&
           std::max(motor.ripple_deviation_Ohm, motor.ripple_2_deviation_Ohm) <=
               kEnoughRipple * motor.resistance_Ohm;
}

/// R as the guard knows it at a start.
double guarded_Ohm(const device::DeviceDescription &device, std::size_t motor) {
    return device::WindingGuard(device.motor[motor], device.amplifier.max_cancelled_Ohm, kPeriod_s,
                                device.resistance_tolerance(motor))
        .max_cancelled_Ohm();
}

/// Averaged over the commutator's angles.
Cancellable cancellable(const device::MotorParameters &file, control::ObservedMotor known,
                        double guard_Ohm, double dR_Ohm) {
    const double R_Ohm = known.mean.resistance_Ohm;
    known.here.resistance_Ohm = R_Ohm;
    return {std::min(guard_Ohm, control::cancelled_resistance_Ohm(file, known, dR_Ohm)),
            std::max(control::held_up_dR_Ohm(known), R_Ohm - guard_Ohm)};
}

} // namespace

CalibrationRun::CalibrationRun(device::HapticDevice &device, const CalibrationOptions &options,
                               Mover mover)
    : device_(device), options_(options), mover_(std::move(mover)),
      reset_(options.lets_go_on), fit_{BrushFit(device.description(), 0, kPeriod_s),
                                       BrushFit(device.description(), 1, kPeriod_s),
                                       BrushFit(device.description(), 2, kPeriod_s)} {
    const device::DeviceDescription &file = device.description();
    SPRINGDRIVE_ASSERT(!file.calibration); // what was known before would be part of the result
    if (!file.current_sensing.is_shared) {
        throw InputError("the device has separate current sensors for amplifiers and servo "
                         "(shared_with_amplifier = 0): the amplifiers' R cannot be observed");
    }
    for (std::size_t j = 0; j < 3; ++j) {
        const device::MotorParameters &motor = file.motor[j];
        if (motor.resistance_tolerance <= 0.0 || motor.torque_constant_tolerance <= 0.0) {
            throw InputError("the device file states no resistance_tolerance and "
                             "torque_constant_tolerance of its motors: it takes R and k_T for "
                             "exact; add them");
        }
        const double link_m = j == 0 ? file.geometry.upper_arm_m : file.geometry.forearm_m;
        const auto index = static_cast<Eigen::Index>(j);
        drag_A_[index] = options.drag_N * link_m /
                         (file.geometry.transmission_ratio[index] * motor.torque_constant_Nm_per_A);
        at_first_[j] = control::WindingObserver(file, j, kPeriod_s).learned();
        at_first_[j].brush_deviation_V =
            std::max(at_first_[j].brush_deviation_V, motor.max_brush_voltage_V / std::sqrt(12.0));
        motor_[j].before = cancellable(file.motor[j], servo::used_at_start(file, j),
                                       guarded_Ohm(file, j), options.dR_Ohm);
    }
    learned_ = at_first_;
    if (options_.made_at_s == 0) {
        options_.made_at_s = std::time(nullptr);
    }
    inputs_.tuning.dR_Ohm = options.dR_Ohm;
    inputs_.observes_resistance = true;
    ++inputs_.unwatched_count;
    inputs_.hottest = device::hottest_motors(file.motor);
}

double CalibrationRun::time_s() const { return ticks_ * kPeriod_s; }

bool CalibrationRun::step() {
    switch (stage_) {
    case CalibrationStage::rest:
        rest();
        break;
    case CalibrationStage::start:
    case CalibrationStage::motion:
    case CalibrationStage::release:
        tick();
        break;
    case CalibrationStage::done:
        break;
    }
    return stage_ != CalibrationStage::done;
}

void CalibrationRun::rest() {
    const device::Measurement measured = device_.read();
    device::DeviceCommand command = device::DeviceCommand::braking();
    command.number = measured.number;
    command.resets_faults = reset_.may_follow(measured);
    device_.write(command);
    if (++ticks_ >= kResetting_ticks || reset_.has_stop()) {
        servo_ = std::make_unique<servo::Servo>(device_, kRate_hz);
        stage_ = CalibrationStage::start;
        ticks_ = 0;
    }
    if (reset_.has_stop()) {
        stop_for(CalibrationProblem::stopped, "the board reports " +
                                                  device::names_of({device::BoardFaults::kStop}) +
                                                  "; begin anew");
    }
}

void CalibrationRun::tick() {
    if (stage_ == CalibrationStage::motion) {
        excite();
    }
    servo_->publish(inputs_);
    servo_->advance(1);
    servo_->drain([this](const servo::ServoSample &sample) { sample_ = sample; });
    ++ticks_;
    const SafetyState state = sample_.safety.state;
    if (state == SafetyState::tripped) {
        stop_for(CalibrationProblem::stopped, "the safety monitor has stopped the device: " +
                                                  servo::description(sample_.safety) +
                                                  "; begin anew");
        return;
    }
    switch (stage_) {
    case CalibrationStage::start:
        if (state == SafetyState::running) {
            stage_ = CalibrationStage::motion;
            ticks_ = 0;
            lowest_rad_ = highest_rad_ = before_rad_ = sample_.theta_rad;
            if (mover_) {
                mover_(motion_left_s());
            }
        } else if (ticks_ >= kMaxStart_ticks) {
            stop_for(CalibrationProblem::never_at_rest,
                     "the tip was never at rest, so the motors could not start; hold it still");
        }
        break;
    case CalibrationStage::motion:
        watch_progress();
        break;
    default:
        // The gains have ramped down, and the board has been told to brake.
        if (state == SafetyState::waiting && ++braking_ticks_ >= kBraking_ticks) {
            servo_->stop();
            stage_ = CalibrationStage::done;
        }
        break;
    }
}

void CalibrationRun::excite() {
    for (Eigen::Index j = 0; j < 3; ++j) {
        const auto motor = static_cast<std::size_t>(j);
        const double turned_rad = sample_.theta_rad[j] - before_rad_[j];
        way_[j] += (turned_rad - std::abs(turned_rad) * way_[j]) / kWholeDrag_rad -
                   way_[j] * kPeriod_s / kFading_s;
        const double share =
            std::clamp(way_[j] + sample_.theta_rate_rad_per_s[j] / kWholeDrag_rad_per_s, -1.0, 1.0);
        const double phase_rad = 2.0 * std::numbers::pi * kDrag_hz[motor] * time_s();
        const double level_A =
            drag_A_[j] * (kLowLevel + 0.5 * (1.0 - kLowLevel) * (1.0 - std::cos(phase_rad)));
        const double residual_Ohm = std::max(0.0, sample_.motor[motor].mean.resistance_Ohm -
                                                      sample_.command.cancelled_resistance_Ohm[j]);
        if (std::abs(share) > kNearlyWhole) {
            const double missing_A =
                std::abs(share) * level_A + std::copysign(1.0, share) * sample_.current_A[j];
            brush_V_[j] =
                std::clamp(brush_V_[j] + residual_Ohm * missing_A * kPeriod_s / kFollowing_s, 0.0,
                           device_.description().motor[motor].max_brush_voltage_V);
        }
        inputs_.excitation_V[j] = -(residual_Ohm * level_A + brush_V_[j]) * share;
        motor_[motor].turned_rad += std::abs(sample_.theta_rate_rad_per_s[j]) * kPeriod_s;
    }
    before_rad_ = sample_.theta_rad;
}

void CalibrationRun::note_brushes() {
    for (std::size_t j = 0; j < 3; ++j) {
        if (const std::optional<control::DrivenInterval> &interval =
                servo_->observers().interval(j)) {
            fit_[j].update(*interval);
        } else {
            fit_[j].skip(sample_.current_A[static_cast<Eigen::Index>(j)]);
        }
        if ((motion_ticks_ + static_cast<int>(j) * kFit_ticks / 3) % kFit_ticks == 0) {
            fitted_[j] = fit_[j].estimate();
        }
    }
}

void CalibrationRun::watch_progress() {
    ++motion_ticks_;
    note_brushes();
    lowest_rad_ = lowest_rad_.cwiseMin(sample_.theta_rad);
    highest_rad_ = highest_rad_.cwiseMax(sample_.theta_rad);
    for (std::size_t j = 0; j < 3; ++j) {
        if (!sample_.motor[j].is_trusted) {
            stop_for(CalibrationProblem::contradiction,
                     fmt::format("what motor {}'s current sensor and encoder say contradicts the "
                                 "device file, or itself; springdrive device self-test names it",
                                 j + 1));
            return;
        }
    }
    const double now = share();
    if (now > best_share_ + kGain) {
        best_share_ = now;
        ticks_without_gain_ = 0;
    } else {
        ++ticks_without_gain_;
    }
    const bool gains_no_more = ticks_without_gain_ >= kNoGain_ticks &&
                               is_known_enough(learned(0)) && is_known_enough(learned(1)) &&
                               is_known_enough(learned(2));
    if (has_reached_all() || gains_no_more || time_s() >= options_.longest_motion_s) {
        finish();
    }
}

void CalibrationRun::finish() {
    if (stage_ != CalibrationStage::motion) {
        return;
    }
    const device::DeviceDescription &file = device_.description();
    has_moved_ = true;
    for (std::size_t j = 0; j < 3; ++j) {
        fitted_[j] = fit_[j].estimate();
        learned_[j] = learned(j);
        motor_[j].now = cancellable(file.motor[j], sample_.motor[j],
                                    sample_.winding[j].R_hat_limit_Ohm, options_.dR_Ohm);
        if (problem_.empty() && !is_known_enough(learned_[j])) {
            refuse(
                CalibrationProblem::little_motion,
                fmt::format("motor {} was not turned enough: R is known to {:.2g} Ohm only, and "
                            "V_b {}; begin anew, and {}",
                            j + 1, learned_[j].resistance_deviation_Ohm,
                            learned_[j].brush_deviation_V > 0.0
                                ? fmt::format("to {:.2g} mV", 1e3 * learned_[j].brush_deviation_V)
                                : "not at all",
                            kMotions[j]));
        }
        if (const std::string contradicts = contradiction(j);
            problem_.empty() && !contradicts.empty()) {
            refuse(CalibrationProblem::contradiction, contradicts);
        }
    }
    device::DeviceDescription calibrated = file;
    calibrated.calibration = calibration();
    if (const std::string wrong = device::validate(*calibrated.calibration, file);
        problem_.empty() && !wrong.empty()) {
        refuse(CalibrationProblem::of_another_kind,
               wrong + ": it is another motor than the device file's; correct the device file");
    }
    for (std::size_t j = 0; j < 3; ++j) {
        motor_[j].at_start = cancellable(file.motor[j], servo::used_at_start(calibrated, j),
                                         guarded_Ohm(file, j), options_.dR_Ohm);
    }
    is_complete_ = problem_.empty();
    inputs_.excitation_V.setZero();
    inputs_.release = true;
    stage_ = CalibrationStage::release;
    ticks_ = 0;
}

void CalibrationRun::refuse(CalibrationProblem kind, std::string problem) {
    kind_ = kind;
    problem_ = std::move(problem);
}

void CalibrationRun::stop_for(CalibrationProblem kind, std::string problem) {
    refuse(kind, std::move(problem));
    is_complete_ = false;
    servo_->stop();
    stage_ = CalibrationStage::done;
}

device::MotorCalibration CalibrationRun::learned(std::size_t motor) const {
    device::MotorCalibration learned = servo_->observers().observer(motor).learned();
    const BrushEstimate &fitted = fitted_[motor];
    learned.brush_voltage_V = learned.brush_deviation_V = 0.0; // an i_b is not the observer's
    if (std::isfinite(fitted.deviation_V)) {
        learned.resistance_Ohm = fitted.resistance.resistance_Ohm;
        learned.resistance_deviation_Ohm = fitted.resistance.deviation_Ohm;
        learned.brush_voltage_V = fitted.voltage_V;
        learned.brush_deviation_V = fitted.deviation_V;
        learned.min_brush_current_A = fitted.min_A;
        learned.max_brush_current_A = fitted.max_A;
    }
    return learned;
}

/// Empty, or how the observer's R or V_b is not that of the levels.
std::string CalibrationRun::contradiction(std::size_t motor) const {
    const device::MotorCalibration observed = servo_->observers().observer(motor).learned();
    const BrushEstimate &fitted = fitted_[motor];
    const auto differ = [](double one, double other, double deviation, double other_deviation,
                           double unknown) {
        return std::abs(one - other) >
               unknown + kContradiction * std::hypot(deviation, other_deviation);
    };
    const double brush_V = kUnknownBrush * std::abs(fitted.voltage_V);
    const bool has_brushes = observed.brush_deviation_V > 0.0;
    if (!has_brushes || !std::isfinite(fitted.deviation_V) ||
        (!differ(observed.resistance_Ohm, fitted.resistance.resistance_Ohm,
                 observed.resistance_deviation_Ohm, fitted.resistance.deviation_Ohm,
                 kUnknownHeat * observed.resistance_Ohm + brush_V / kBetweenLevels_A) &&
         !differ(observed.brush_voltage_V, fitted.voltage_V, observed.brush_deviation_V,
                 fitted.deviation_V, brush_V))) {
        return "";
    }
    return fmt::format("motor {}: between levels of current R is {:.4f} Ohm and V_b {:.1f} mV, but "
                       "from tick to tick {:.4f} Ohm and {:.1f} mV; springdrive device self-test "
                       "looks for the cause",
                       motor + 1, fitted.resistance.resistance_Ohm, 1e3 * fitted.voltage_V,
                       observed.resistance_Ohm, 1e3 * observed.brush_voltage_V);
}

/// 0 with the file alone, 1 where R, ripple and V_b are known as well as they should be: each tenth
/// of the deviation is as much.
double CalibrationRun::share_of(std::size_t motor) const {
    const device::MotorCalibration now = learned(motor);
    const device::MotorCalibration &first = at_first_[motor];
    const double requested_Ohm = kRequested * first.resistance_Ohm;
    double most = 0.0;
    const auto add = [&](double device::MotorCalibration::*deviation, double requested) {
        if (first.*deviation > requested) {
            const double left = now.*deviation > 0.0 ? now.*deviation : first.*deviation;
            most =
                std::max(most, std::log(left / requested) / std::log(first.*deviation / requested));
        }
    };
    add(&device::MotorCalibration::resistance_deviation_Ohm, requested_Ohm);
    const double requested_ripple_Ohm = kRequestedRipple * first.resistance_Ohm;
    add(&device::MotorCalibration::ripple_deviation_Ohm, requested_ripple_Ohm);
    add(&device::MotorCalibration::ripple_2_deviation_Ohm, requested_ripple_Ohm);
    add(&device::MotorCalibration::brush_deviation_V, requested_Ohm * kBetweenLevels_A);
    return 1.0 - std::min(1.0, most);
}

bool CalibrationRun::has_reached_all() const {
    return stage_ > CalibrationStage::motion ||
           (stage_ == CalibrationStage::motion && share() >= 1.0);
}

double CalibrationRun::share() const {
    switch (stage_) {
    case CalibrationStage::rest:
        return static_cast<double>(ticks_) / kResetting_ticks;
    case CalibrationStage::start:
        return sample_.safety.ramp;
    case CalibrationStage::motion:
        return std::min({share_of(0), share_of(1), share_of(2)});
    case CalibrationStage::release:
        return 1.0 - sample_.safety.ramp;
    case CalibrationStage::done:
        break;
    }
    return 1.0;
}

std::size_t CalibrationRun::min_known() const {
    if (stage_ != CalibrationStage::motion) {
        return 0;
    }
    std::size_t least = 0;
    for (std::size_t j = 1; j < 3; ++j) {
        least = share_of(j) < share_of(least) ? j : least;
    }
    return least;
}

std::array<MotorProgress, 3> CalibrationRun::progress() const {
    std::array<MotorProgress, 3> progress;
    if (!servo_) {
        return progress;
    }
    for (std::size_t j = 0; j < 3; ++j) {
        const device::MotorCalibration known = learned(j);
        const auto index = static_cast<Eigen::Index>(j);
        progress[j] = {share_of(j), known.resistance_Ohm, known.resistance_deviation_Ohm,
                       (highest_rad_[index] - lowest_rad_[index]) /
                           device_.description().geometry.transmission_ratio[index]};
    }
    return progress;
}

double CalibrationRun::motion_left_s() const {
    return std::max(0.0, options_.longest_motion_s - motion_ticks_ * kPeriod_s);
}

std::string CalibrationRun::instruction(CalibrationStage stage, std::size_t min_known) {
    switch (stage) {
    case CalibrationStage::rest:
    case CalibrationStage::start:
        return "hold the stylus still in free space: the motors start";
    case CalibrationStage::motion:
        return fmt::format("{}, slowly, over a hand's breadth; it resists gently",
                           kMotions[min_known]);
    case CalibrationStage::release:
        return "hold the stylus: the motors are released";
    case CalibrationStage::done:
        break;
    }
    return "";
}

device::Calibration CalibrationRun::calibration() const {
    const device::DeviceDescription &file = device_.description();
    const device::DeviceIdentity identity = device_.identity();
    device::Calibration calibration;
    calibration.serial = identity.serial;
    calibration.kind = identity.kind;
    calibration.firmware = identity.firmware;
    calibration.made_at_s = options_.made_at_s;
    if (options_.air_C) {
        calibration.air_C = *options_.air_C;
        calibration.air_error_K = kThermometer_K;
    }
    for (std::size_t j = 0; j < 3; ++j) {
        // What was learned takes the air for one of 25 °C.
        const double to_25_C =
            1.0 / (1.0 + file.motor[j].resistance_rise_per_K *
                             (calibration.air_C - device::kReferenceTemperature_C));
        device::MotorCalibration motor = learned_[j];
        for (double device::MotorCalibration::*const value :
             {&device::MotorCalibration::resistance_Ohm,
              &device::MotorCalibration::resistance_deviation_Ohm,
              &device::MotorCalibration::ripple_cos_Ohm, &device::MotorCalibration::ripple_sin_Ohm,
              &device::MotorCalibration::ripple_deviation_Ohm,
              &device::MotorCalibration::ripple_cos_2_Ohm,
              &device::MotorCalibration::ripple_sin_2_Ohm,
              &device::MotorCalibration::ripple_2_deviation_Ohm}) {
            motor.*value *= to_25_C;
        }
        calibration.motor[j] = motor;
    }
    return calibration;
}

CalibrationReport CalibrationRun::report() const {
    CalibrationReport report;
    report.is_complete = is_complete_ && stage_ == CalibrationStage::done;
    report.kind = kind_;
    report.problem = problem_;
    if (kind_ == CalibrationProblem::stopped) {
        report.trip = sample_.safety.cause;
    }
    if (has_moved_) {
        report.calibration = calibration();
        report.motor = motor_;
    }
    report.motion_s = motion_ticks_ * kPeriod_s;
    if (!report.is_complete && report.problem.empty()) {
        report.kind = CalibrationProblem::ended;
        report.problem = "it was ended before anything was learned";
    }
    return report;
}

} // namespace springdrive::commissioning

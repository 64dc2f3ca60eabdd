#include "engine/commissioning/sweep.h"

#include "base/degrees.h"
#include "base/input_error.h"
#include "device/core/motor/motor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace springdrive::commissioning {

namespace {

using servo::SafetyState;
using servo::ServoSample;

/// While the device still brakes: d of the packets that a servo exchanges is measured first, as the
/// observer of R needs it. As many as the driver's mean goes back.
constexpr int kDelayTicks = 256;
constexpr double kMaxRest_s = 60.0; ///< until the tip has rested in free space
constexpr double kHold_s = 0.5;     ///< until what changed with the hold has decayed

// R is observed while all motors are shaken slowly, within the observer's windows.
constexpr double kObserving_hz = 5.0;
constexpr double kObserving_rad = 0.08;
constexpr double kMinObserving_s = 4.0;
constexpr double kMaxObserving_s = 8.0;
constexpr double kObserved = 0.01; ///< deviation of R, as a share of dR

/// Ticks of a block at least: it begins and ends with periods of the sine, which changes the
/// frequency by no more than 1/500.
constexpr long kBlockTicks = 250;
constexpr std::size_t kMinBlocks = 6;
constexpr std::size_t kMaxBlocks = 16;
constexpr double kRequestedDeviation = 3e-3; ///< deviation of K_θ as a share of it
constexpr unsigned kMaxDiscarded = 200;

/// A dither beside the sine, so that the rounding of its counts averages out: slow, or faster than
/// a slow sine. Its frequency is irrational in blocks, so that no two round alike.
constexpr long kSlowDither_periods = 3; ///< of the sine in a block, at least
constexpr double kDither_counts = 5.0;
constexpr double kDitherForceShare = 0.05; ///< of the limit

/// In a block.
double dither_periods(long sine_periods) {
    return std::numbers::phi *
           (sine_periods >= kSlowDither_periods ? 1.0 : 1.0 + static_cast<double>(sine_periods));
}

// Amplitudes.
constexpr double kFirst_V = 0.02;
constexpr double kMin_V = 1e-3;
constexpr double kMaxSupplyShare = 0.2; ///< of the supply
constexpr double kForceShare = 0.3;     ///< of the limit, for the excitation's amplitude
constexpr double kAllForceShare = 0.7;  ///< of the limit, with what holds the tip
constexpr double kForceTooMuch = 0.85;  ///< of the limit
constexpr double kCurrentShare = 0.3;
constexpr double kSpeedShare = 0.2;
constexpr double kEnergyShare = 1.0 / 3.0;
constexpr double kEnergyTooMuch = 0.5;
constexpr double kChange_s = 0.05; ///< of the amplitude
constexpr double kCalm_s = 0.2;    ///< after too much
constexpr double kTrial_s = 0.06;  ///< at least, and a period
constexpr double kSettle_s = 0.2;  ///< the same
constexpr int kMaxTrials = 12;
constexpr double kNextShare = 0.4; ///< of an amplitude, for the next frequency to begin with
constexpr double kFitting = 0.95;  ///< of what there is room for
constexpr double kGoodLeast = 0.8; ///< room that needs no other amplitude
constexpr double kGoodMost = 1.6;
constexpr double kMaxGrowth = 4.0;

/// A tick is on time within this share of T.
constexpr double kOnTime = 0.05;

double half_of(const Vector3 &least, const Vector3 &most) { return 0.5 * (most - least).norm(); }

} // namespace

bool SweepReport::is_certain() const {
    return is_complete && std::ranges::all_of(motors, [](const MotorSweep &sweep) {
               return std::ranges::all_of(sweep.points, [](const SweepPoint &point) {
                   return point.deviation <= kUncertain; // not for NaN
               });
           });
}

bool SweepReport::is_within(double share, double phase_rad) const {
    return std::ranges::all_of(motors, [&](const MotorSweep &sweep) {
        return std::ranges::all_of(sweep.points, [&](const SweepPoint &point) {
            return std::abs(point.magnitude_error()) <= share &&
                   std::abs(point.phase_error_rad()) <= phase_rad;
        });
    });
}

void StiffnessSweep::Extent::take(const ServoSample &sample, Eigen::Index motor) noexcept {
    const double current_A = sample.current_A[motor];
    if (is_empty) {
        is_empty = false;
        min_m = max_m = sample.tip_m;
        least_N = most_N = sample.tip_force_N;
        least_A = most_A = current_A;
    }
    min_m = min_m.cwiseMin(sample.tip_m);
    max_m = max_m.cwiseMax(sample.tip_m);
    least_N = least_N.cwiseMin(sample.tip_force_N);
    most_N = most_N.cwiseMax(sample.tip_force_N);
    least_A = std::min(least_A, current_A);
    most_A = std::max(most_A, current_A);
    energy_J = std::max(energy_J, sample.generated_energy_J);
    force_N = std::max(force_N, sample.tip_force_N.norm());
}

SweepOptions checked_sweep_options(const device::DeviceDescription &device, SweepOptions options) {
    const auto check = [](const char *what, double value, double least, double most) {
        if (!(value >= least && value <= most)) { // a NaN too
            throw InputError(
                fmt::format("{} is {:g}; it must be from {:g} to {:g}", what, value, least, most));
        }
    };
    static_cast<void>(servo::servo_period_s(options.servo_hz));
    const double max_hz = options.max_hz.value_or(0.1 * options.servo_hz);
    options.max_hz = max_hz;
    constexpr double kLowest_hz = 0.1;
    const double highest_hz = 0.25 * options.servo_hz;
    check("--freq-from", options.min_hz, kLowest_hz, highest_hz);
    check("--freq-to", max_hz, kLowest_hz, highest_hz);
    if (!(options.min_hz < max_hz)) {
        throw InputError("--freq-from must be below --freq-to");
    }
    check("--points", options.points, 2, 200);
    check("--tip-force", options.tip_force_N, 0.5, servo::limits_of(device).tip_force_N);
    check("--motion", options.motion_m, 1e-4, 5e-3);
    std::ranges::sort(options.motors);
    if (options.motors.empty() || options.motors.back() > 2 ||
        std::ranges::adjacent_find(options.motors) != options.motors.end()) {
        throw InputError("--motors must be some of 1, 2 and 3, each once");
    }
    if (const std::string wrong = control::validate(options.tuning); !wrong.empty()) {
        throw InputError("sweep: " + wrong);
    }
    options.tuning.map = control::MotionMap::inverse;
    options.tuning.eta = 0.0;
    return options;
}

StiffnessSweep::StiffnessSweep(device::HapticDevice &device, const SweepOptions &options)
    : device_(device), options_(checked_sweep_options(device.description(), options)),
      limits_(servo::limits_of(device.description())), servo_(device, options_.servo_hz) {
    if (!device.is_zeroed()) {
        throw InputError("the device is not zeroed, so its angles are not known; hold it in its "
                         "zero pose, and declare that");
    }
    servo_.set_rate(options_.servo_hz); // the device's, too
    inputs_.tuning = options_.tuning;
    inputs_.limits.tip_force_N = options_.tip_force_N;
    inputs_.release = true; // until d is measured
    inputs_.observes_resistance = options_.observes_resistance;
    if (options_.observes_resistance && !device.description().current_sensing.is_shared) {
        warnings_.emplace_back(
            "the servo's current sensors are not those of the amplifiers, so R is "
            "not observed: dR is that of the device file's R");
    }
    plan();
}

/// From the highest frequency on: its trials are the shortest, and the next one begins with what
/// they found.
void StiffnessSweep::plan() {
    const double T = servo_.period_s();
    const double ratio = std::log(*options_.max_hz / options_.min_hz) / (options_.points - 1);
    for (const std::size_t motor : options_.motors) {
        for (int i = options_.points - 1; i >= 0; --i) {
            const double cycles = options_.min_hz * std::exp(ratio * i) * T; // a tick
            Task task;
            task.motor = motor;
            task.periods = std::max(1L, std::lround(std::ceil(kBlockTicks * cycles)));
            task.ticks = std::lround(std::ceil(static_cast<double>(task.periods) / cycles - 1e-9));
            // So that a block has as many different phases as ticks.
            while (std::gcd(task.ticks, task.periods) > 1) {
                ++task.ticks;
            }
            tasks_.push_back(task);
        }
    }
    measured_.reserve(tasks_.size());
}

bool StiffnessSweep::step() {
    if (stage_ == SweepStage::done) {
        return false;
    }
    publish();
    servo_.advance(1);
    bool has_new = false;
    servo_.drain([&](const ServoSample &sample) {
        sample_ = sample;
        has_new = true;
    });
    if (!has_new) { // an assertion failed: the next tick says so, and brakes
        return true;
    }
    if (!has_sample_) {
        has_sample_ = true;
        origin_s_ = sample_.measured_s;
    }
    now_s_ = sample_.measured_s - origin_s_;
    act(sample_);
    return stage_ != SweepStage::done;
}

void StiffnessSweep::publish() {
    inputs_.excitation_V.setZero();
    if (stage_ == SweepStage::observing) {
        sine_.pass(servo_.period_s());
        inputs_.excitation_V.setConstant(
            sine_.now_V *
            std::sin(2.0 * std::numbers::pi * kObserving_hz * (now_s_ - stage_began_s_)));
    } else if (stage_ == SweepStage::measuring) {
        inputs_.excitation_V[motor_index()] = excitation_V();
    }
    servo_.publish(inputs_);
}

/// For the measurement that comes next.
double StiffnessSweep::excitation_V() noexcept {
    const double T = servo_.period_s();
    sine_.pass(T);
    dither_.pass(T);
    const double next_s = now_s_ + T;
    return sine_.now_V * std::sin(measurement_.omega_rad_per_s() * next_s) +
           dither_.now_V * std::sin(dither_rad_per_s_ * next_s);
}

void StiffnessSweep::act(const ServoSample &sample) {
    if (sample.safety.state == SafetyState::tripped) {
        // Running the command is the person's reset of what the board had latched before.
        if (stage_ == SweepStage::resting && sample.safety.cause == servo::TripCause::board_fault &&
            inputs_.reset_count == 0) {
            ++inputs_.reset_count;
            inputs_.released_stop = sample.safety.held_stop;
            return;
        }
        end("the safety monitor ended the sweep, and the device brakes: " +
            servo::description(sample.safety));
        return;
    }
    switch (stage_) {
    case SweepStage::resting:
        rest(sample);
        break;
    case SweepStage::holding:
        hold();
        break;
    case SweepStage::observing:
        observe(sample);
        break;
    case SweepStage::measuring:
        measure(sample);
        break;
    case SweepStage::releasing:
        if (sample.safety.state == SafetyState::waiting) {
            is_complete_ = true;
            end("");
        }
        break;
    case SweepStage::done:
        break;
    }
}

void StiffnessSweep::rest(const ServoSample &sample) {
    if (inputs_.release) {
        if (++braked_ticks_ == kDelayTicks) {
            servo_.set_rate(options_.servo_hz); // takes over d
            inputs_.release = false;
        }
        return;
    }
    if (sample.safety.state == SafetyState::running) {
        inputs_.fixed_x0_m = sample.tip_m;
        enter(SweepStage::holding);
    } else if (now_s_ > kMaxRest_s) {
        end(fmt::format("the tip has not been at rest within {:.0f} s; hold it still, and begin "
                        "anew",
                        kMaxRest_s));
    }
}

void StiffnessSweep::hold() {
    if (now_s_ - stage_began_s_ < kHold_s) {
        return;
    }
    if (options_.observes_resistance && device_.description().current_sensing.is_shared) {
        sine_.change(std::min(options_.tuning.K_P_V_per_rad * kObserving_rad, largest_V()));
        enter(SweepStage::observing);
    } else {
        enter(SweepStage::measuring);
        begin_task(kFirst_V);
    }
}

void StiffnessSweep::observe(const ServoSample &sample) {
    const double since_s = now_s_ - stage_began_s_;
    if (sine_.requested_V == 0.0) { // it is known, and the excitation fades
        if (since_s >= kCalm_s) {
            enter(SweepStage::measuring);
            begin_task(kFirst_V);
        }
        return;
    }
    if (since_s < kMinObserving_s) {
        return;
    }
    const auto is_known = [&](std::size_t motor) {
        const control::ObservedMotor &known = sample.motor[motor];
        return known.is_trusted && control::held_up_dR_Ohm(known) <= options_.tuning.dR_Ohm &&
               known.here.deviation_Ohm <= kObserved * options_.tuning.dR_Ohm;
    };
    if (!std::ranges::all_of(options_.motors, is_known) && since_s < kMaxObserving_s) {
        return;
    }
    for (const std::size_t motor : options_.motors) {
        const control::ObservedMotor &known = sample.motor[motor];
        if (!is_known(motor) && known.is_trusted) { // others: note_distrust
            warnings_.push_back(fmt::format(
                "R of motor {} is known to {:.1f} mΩ, so dR may differ from what was asked for",
                motor + 1, 1e3 * std::max(known.here.deviation_Ohm, known.mean.deviation_Ohm)));
        }
    }
    sine_.change(0.0);
    stage_began_s_ = now_s_;
}

void StiffnessSweep::Amplitude::change(double to_V) noexcept {
    requested_V = to_V;
    rate_V_per_s = std::abs(to_V - now_V) / kChange_s;
}

void StiffnessSweep::Amplitude::pass(double time_s) noexcept {
    const double step_V = rate_V_per_s * time_s;
    now_V = std::clamp(requested_V, now_V - step_V, now_V + step_V);
}

/// Against the spring K_P it moves the rotor by some counts; a fast one moves its inertia, and is
/// limited by the force that this takes.
double StiffnessSweep::dither_V(const Task &task) const {
    const device::DeviceDescription &description = device_.description();
    const double slow_V =
        options_.tuning.K_P_V_per_rad * kDither_counts * description.rad_per_count();
    if (task.periods >= kSlowDither_periods) {
        return std::min(slow_V, largest_V());
    }
    const double force_N_per_A = description.motor[task.motor].torque_constant_Nm_per_A *
                                 description.geometry.transmission_ratio[motor_index()] /
                                 description.geometry.upper_arm_m;
    return std::min(
        {slow_V, largest_V(),
         kDitherForceShare * options_.tip_force_N / force_N_per_A * options_.tuning.dR_Ohm});
}

void StiffnessSweep::begin_task(double first_V) {
    const Task &task = tasks_[task_];
    measurement_ = {};
    measurement_.blocks.reserve(kMaxBlocks);
    measurement_.motor = task.motor;
    measurement_.frequency_hz =
        static_cast<double>(task.periods) / (static_cast<double>(task.ticks) * servo_.period_s());
    dither_rad_per_s_ = 2.0 * std::numbers::pi * dither_periods(task.periods) / block_s();
    dither_.change(dither_V(task));
    try_amplitude(first_V);
    trials_ = 0;
    delay_sum_ = k_T_sum_ = cancelled_sum_Ohm_ = 0.0;
    summed_ticks_ = 0;
}

/// To the next frequency, or to the end.
void StiffnessSweep::end_task() {
    const std::size_t motor = tasks_[task_].motor;
    ++task_;
    if (task_ == tasks_.size()) {
        inputs_.release = true;
        enter(SweepStage::releasing);
        return;
    }
    begin_task(tasks_[task_].motor == motor
                   ? std::max(kMin_V, kNextShare * measurement_.excitation_V)
                   : kFirst_V);
}

void StiffnessSweep::try_amplitude(double requested_V) noexcept {
    const double to_V = std::min(requested_V, largest_V());
    is_rising_ = to_V > sine_.now_V;
    changing_s_ = kChange_s;
    sine_.change(to_V);
    enter(Phase::changing);
}

void StiffnessSweep::measure(const ServoSample &sample) {
    const double since_s = now_s_ - phase_began_s_;
    const double period_s = 1.0 / measurement_.frequency_hz;
    const bool is_falling = phase_ == Phase::fading || (phase_ == Phase::changing && !is_rising_);
    if (!is_falling && is_too_much(sample)) {
        retreat();
        return;
    }
    switch (phase_) {
    case Phase::changing:
        if (since_s >= changing_s_) {
            extent_ = {};
            enter(Phase::trying);
        }
        break;
    case Phase::trying:
        extent_.take(sample, motor_index());
        if (since_s >= std::max(kTrial_s, period_s)) {
            adapt();
        }
        break;
    case Phase::settling:
        if (since_s >= std::max(kSettle_s, period_s)) {
            enter(Phase::measuring);
            begin_block();
        }
        break;
    case Phase::measuring:
        take_tick(sample);
        break;
    case Phase::fading:
        if (since_s >= kChange_s) {
            end_task();
        }
        break;
    }
}

bool StiffnessSweep::is_too_much(const ServoSample &sample) const noexcept {
    return sample.active_limits.holds_force() || sample.active_limits.voltage ||
           sample.tip_force_N.norm() > kForceTooMuch * options_.tip_force_N ||
           is_too_much_energy(sample);
}

bool StiffnessSweep::is_too_much_energy(const ServoSample &sample) const noexcept {
    return sample.generated_energy_J > kEnergyTooMuch * limits_.generated_energy_J;
}

/// To less, at once.
void StiffnessSweep::retreat() {
    constexpr double kRetreat = 0.5;
    discarded_ += phase_ == Phase::measuring ? 1 : 0;
    if (sine_.requested_V <= kMin_V) {
        end("the tip's force, or the energy that the hand gets, is near its limit even without an "
            "excitation; hold the tip loosely, or allow more force");
        return;
    }
    ++trials_;
    measurement_.blocks.clear();
    try_amplitude(std::max(kMin_V, kRetreat * sine_.requested_V));
    // Until the tip is calm again, or the observer has forgotten most of the energy.
    is_rising_ = false;
    changing_s_ = is_too_much_energy(sample_) ? servo::EnergyObserver::kMemory_s : kCalm_s;
}

/// By which the amplitude may grow.
double StiffnessSweep::room() const noexcept {
    const double force_N = half_of(extent_.least_N, extent_.most_N);
    const double motion_m = half_of(extent_.min_m, extent_.max_m);
    const double current_A = 0.5 * (extent_.most_A - extent_.least_A);
    const double speed_m_per_s = measurement_.omega_rad_per_s() * motion_m;
    const double energy = extent_.energy_J / (kEnergyShare * limits_.generated_energy_J);
    const double used = std::max({
        force_N / (kForceShare * options_.tip_force_N),
        extent_.force_N / (kAllForceShare * options_.tip_force_N),
        motion_m / options_.motion_m,
        current_A / (kCurrentShare * limits_.current_A),
        speed_m_per_s / (kSpeedShare * limits_.tip_speed_m_per_s),
        std::sqrt(std::max(0.0, energy)), // it rises with the square of the amplitude
        sine_.requested_V / largest_V(),
    });
    return 1.0 / used;
}

void StiffnessSweep::adapt() {
    const double its_room = room();
    const bool is_good = its_room >= kGoodLeast && its_room <= kGoodMost;
    ++trials_;
    if (is_good || (trials_ >= kMaxTrials && its_room >= kGoodLeast)) {
        enter(Phase::settling);
        return;
    }
    if (its_room < kGoodLeast && sine_.requested_V <= kMin_V) {
        retreat();
        return;
    }
    try_amplitude(std::max(
        kMin_V, sine_.requested_V * std::clamp(kFitting * its_room, 1.0 / kMaxGrowth, kMaxGrowth)));
}

void StiffnessSweep::begin_block() {
    block_ = SweepBlock(measurement_.omega_rad_per_s(), dither_rad_per_s_, block_s());
    block_ticks_ = 0;
}

bool StiffnessSweep::is_clean(const ServoSample &sample) const noexcept {
    const double T = servo_.period_s();
    return sample.arrival == device::Arrival::fresh && sample.missed_periods == 0 &&
           std::abs(sample.since_last_s - T) < kOnTime * T && !sample.active_limits.at_edge &&
           sample.safety.state == SafetyState::running;
}

void StiffnessSweep::take_tick(const ServoSample &sample) {
    if (!is_clean(sample)) {
        if (++discarded_ > kMaxDiscarded) {
            end("too many measurements were late or lost; `springdrive doctor --device usb` names "
                "what is in the way");
            return;
        }
        begin_block();
        return;
    }
    if (block_ticks_ == 0) {
        block_began_s_ = sample.measured_s;
    }
    const Eigen::Index motor = motor_index();
    block_.take({sample.measured_s - block_began_s_, inputs_.excitation_V[motor],
                 sample.command.e_W_V[motor], sample.current_A[motor], sample.theta_rad[motor]});
    delay_sum_ += device_.delay_periods();
    k_T_sum_ += sample.motor[tasks_[task_].motor].torque_constant_Nm_per_A;
    cancelled_sum_Ohm_ += sample.command.cancelled_resistance_Ohm[motor];
    ++summed_ticks_;
    if (++block_ticks_ == tasks_[task_].ticks) {
        take_block();
    }
}

/// A motor that is observed no more keeps the file's R, from then on.
void StiffnessSweep::note_distrust() {
    const std::size_t motor = measurement_.motor;
    if (sample_.motor[motor].is_trusted || is_distrusted_[motor]) {
        return;
    }
    is_distrusted_[motor] = true;
    warnings_.push_back(fmt::format("R of motor {} is not trusted as it was observed, so dR may "
                                    "differ from what was asked for",
                                    motor + 1));
}

void StiffnessSweep::take_block() {
    note_distrust();
    measurement_.blocks.push_back(block_.amplitudes());
    const auto ticks = static_cast<double>(summed_ticks_);
    measurement_.delay_periods = delay_sum_ / ticks;
    measurement_.torque_constant_Nm_per_A = k_T_sum_ / ticks;
    measurement_.cancelled_Ohm = cancelled_sum_Ohm_ / ticks;
    measurement_.excitation_V = sine_.now_V;
    const std::size_t blocks = measurement_.blocks.size();
    const bool is_known =
        blocks >= kMinBlocks &&
        estimated_deviation(drive_of(measurement_.motor), measurement_) < kRequestedDeviation;
    if (!is_known && blocks < kMaxBlocks) {
        begin_block();
        return;
    }
    measured_.push_back(measurement_);
    sine_.change(0.0);
    dither_.change(0.0);
    enter(Phase::fading);
}

void StiffnessSweep::enter(SweepStage stage) noexcept {
    stage_ = stage;
    stage_began_s_ = now_s_;
}

void StiffnessSweep::enter(Phase phase) noexcept {
    phase_ = phase;
    phase_began_s_ = now_s_;
}

void StiffnessSweep::end(std::string problem) {
    problem_ = std::move(problem);
    stop();
}

void StiffnessSweep::stop() noexcept {
    servo_.stop();
    stage_ = SweepStage::done;
}

double StiffnessSweep::block_s() const noexcept {
    return static_cast<double>(tasks_[task_].ticks) * servo_.period_s();
}

double StiffnessSweep::largest_V() const noexcept { return kMaxSupplyShare * limits_.voltage_V; }

Eigen::Index StiffnessSweep::motor_index() const noexcept {
    return static_cast<Eigen::Index>(tasks_[task_].motor);
}

loops::SpringDrive StiffnessSweep::drive_of(std::size_t motor) const {
    return {device_.description().motor[motor], options_.tuning, servo_.period_s(),
            device_.delay_periods()};
}

std::string StiffnessSweep::instruction() const {
    switch (stage_) {
    case SweepStage::resting:
        return "hold the tip still, away from the ends of its workspace: the motors start";
    case SweepStage::holding:
    case SweepStage::observing:
        return "the tip is held where it is; keep a relaxed hand on it until the end";
    case SweepStage::measuring:
        return fmt::format("motor {}", tasks_[task_].motor + 1);
    case SweepStage::releasing:
        return "the motors let go";
    case SweepStage::done:
        break;
    }
    return "";
}

double StiffnessSweep::share() const {
    const auto all = static_cast<double>(tasks_.size());
    return static_cast<double>(measured_.size()) / all;
}

SweepReport StiffnessSweep::report() const {
    SweepReport report;
    report.is_complete = is_complete_;
    report.problem = problem_;
    report.warnings = warnings_;
    report.discarded_blocks = discarded_;
    for (const std::size_t motor : options_.motors) {
        // clang 14 cannot read std::ranges::equal_range of this standard library.
        const auto first = std::ranges::lower_bound(measured_, motor, {}, &SweepMeasurement::motor);
        const auto last =
            std::ranges::upper_bound(first, measured_.end(), motor, {}, &SweepMeasurement::motor);
        if (first != last) {
            report.motors.push_back(
                estimate_sweep(drive_of(motor), std::span<const SweepMeasurement>(first, last)));
        }
    }
    return report;
}

} // namespace springdrive::commissioning

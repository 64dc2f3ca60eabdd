// The servo, which fails, or stops before it does: missed ticks, jitter, a late or lost device, a
// hung window, a change of scene and a hand that releases.
#include "base/assertions.h"
#include "base/eigenvalues.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/lab/limits/method_limits/experiment_list.h"
#include "engine/lab/limits/method_limits/pressed_corner.h"
#include "engine/lab/limits/stability_simulation.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/servo/servo_timing.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace springdrive::limits {

namespace {

constexpr const char *kServoMethod = "servo";
constexpr double kMilli = 1e3;

/// Tuning firm, all motors, one hand.
loops::StabilityCase firm_in_a_hand(const loops::StabilityCase &which, double firmness) {
    loops::StabilityCase firm = which;
    firm.tuning = control::Tuning{};
    firm.freedom = loops::Freedom::three_motors;
    firm.hands = {loops::hand_of_firmness(firmness)};
    firm.delay_periods = 0;
    return firm;
}

/// The number of consecutive missed deadlines that the monitor tolerates.
int missed_limit(const loops::StabilityCase &which) {
    return static_cast<int>(std::floor(which.device.limits.late_s / which.period_s + 1e-6));
}

/// The largest number, up to a maximum, for which a condition holds, as for all before it.
template <typename Holds> int last_number(int maximum, const Holds &holds) {
    int last = 0;
    while (last < maximum && holds(last + 1)) {
        ++last;
    }
    return last;
}

/// One tick is late. From limit + 1 periods on, the monitor trips.
Experiment late_tick(const loops::StabilityCase &which) {
    const double period_ms = kMilli * which.period_s;
    const int limit = missed_limit(which);
    return {{kServoMethod, "a tick later than", "ms",
             "1 kHz; it stops at more than " + with_unit(limit, "missed deadlines in a row"),
             period_ms * (limit + 1)},
            {0.1 * period_ms, 10.0 * period_ms * (limit + 1), false, 1e-5},
            [=](double late_ms) {
                PressedCorner corner(which, 0.0);
                servo::Deadlines deadlines(1.0 / which.period_s);
                deadlines.begin(deadlines.next_ns() + std::llround(1e6 * late_ms));
                corner.late_tick(static_cast<int>(deadlines.missed()));
                return !corner.has_tripped();
            }};
}

/// Whether a displaced tip comes to rest in the corner, with every other tick late. The motion that
/// the finest encoders sustain is a ten-thousandth of the displacement.
bool motion_decays(const loops::StabilityCase &which, int missed) {
    constexpr double kForce_N = 2.0;
    constexpr double kWatched_s = 3.0;
    constexpr double kEarly_s = 0.2;
    constexpr double kLate_s = 2.5;
    PressedCorner corner(which);
    corner.press(kForce_N);
    corner.nudge();
    double early = 0.0;
    double late = 0.0;
    double time_s = 0.0;
    while (time_s < kWatched_s && !corner.has_tripped()) {
        corner.tick();
        corner.late_tick(missed);
        const double rate = corner.truth().theta_rate_rad_per_s.norm();
        early = time_s < kEarly_s ? std::max(early, rate) : early;
        late = time_s > kLate_s ? std::max(late, rate) : late;
        time_s += which.period_s * (2 + missed);
    }
    return !corner.has_tripped() && late < 0.5 * early;
}

/// Worst-case jitter: on time, late, on time, late.
Experiment every_other_tick_late(const loops::StabilityCase &which) {
    const int maximum = missed_limit(which);
    const int predicted = last_number(maximum, [&](int missed) {
        return late_ticks_eigenvalue(which, loops::members(which).front(), missed) < 1.0;
    });
    return {{kServoMethod, "every other tick later than", "periods",
             "tuning firm, 1 kHz, pressed into a corner by a relaxed hand", predicted},
            {0.0, static_cast<double>(maximum), true},
            [=](double missed) { return motion_decays(which, static_cast<int>(missed)); }};
}

/// Late answers increase d by whole periods, as USB frames that miss their tick do.
Experiment late_answers(const loops::StabilityCase &which) {
    constexpr int kMax = simulated::SimulationOptions::kMaxDelay;
    const auto delayed = [=](int periods) {
        loops::StabilityCase late = which;
        late.tuning.K_P_V_per_rad = 20.0;
        late.delay_periods = periods;
        return late;
    };
    return {{kServoMethod, "answers later than", "periods",
             "K_P 20 V/rad, 1 kHz, pressed into a corner by a relaxed hand",
             last_number(kMax, [&](int periods) { return loops::is_stable(delayed(periods)); })},
            {0.0, static_cast<double>(kMax), true},
            [=](double periods) { return motion_decays(delayed(static_cast<int>(periods)), 0); }};
}

/// Whether the servo keeps running after that many consecutive reads with the fault.
bool survives(const loops::StabilityCase &which, device::FaultKind fault, double reads) {
    constexpr int kTicks = 30; // more than the reads tried, with a few to detect the trip
    PressedCorner corner(which, 0.0);
    corner.device().commit({.kind = fault, .end_s = std::floor(reads)});
    for (int i = 0; i < kTicks; ++i) {
        corner.tick();
    }
    return !corner.has_tripped();
}

/// A lost device stops the servo at once.
Experiment lost_device(const loops::StabilityCase &which) {
    return {{kServoMethod, "device lost for more ticks than", "–",
             "for example unplugged; no command can reach it", 0.0},
            {0.0, 10.0, true},
            [=](double lost) { return survives(which, device::FaultKind::unplug, lost); }};
}

/// The servo waits for a silent device until the budget is exhausted; the last command stays
/// active.
Experiment missing_answers(const loops::StabilityCase &which) {
    const double budget = which.device.limits.stale_s / which.period_s;
    return {{kServoMethod, "measurements missing in a row, more than", "–",
             "1 kHz; the last command stays active meanwhile", std::floor(budget + 1e-6)},
            {0.0, 3.0 * budget, true},
            [=](double missing) { return survives(which, device::FaultKind::drop, missing); }};
}

/// Ticks until a condition holds; nothing if that takes too long.
template <typename Done>
std::optional<double> ticks_until(PressedCorner &corner, long longest, const Done &is_done) {
    for (long ticks = 0; ticks < longest; ++ticks) {
        corner.tick();
        if (is_done()) {
            return static_cast<double>(ticks);
        }
    }
    return std::nullopt;
}

/// The tick that detects the loss commands braking before it ends.
Experiment volts_off(const loops::StabilityCase &which) {
    return {.row = {kServoMethod, "voltage off after", "periods",
                    "the device is lost while a relaxed hand presses", 0.0},
            .reading = [=] {
                PressedCorner corner(which);
                corner.press(2.0);
                corner.device().commit({.kind = device::FaultKind::unplug});
                return ticks_until(
                    corner, 100, [&] { return corner.device().last_command().e_W_V.isZero(0.0); });
            }};
}

/// A tip that is inside a block after a change of scene is free until it has left.
Experiment new_scene(const loops::StabilityCase &which) {
    constexpr double kHalfBlock_m = 0.1;
    constexpr double kDeepest_m = 0.05;
    return {{"proxy", "scene switched in contact, inside deeper than", "mm",
             "pressed by a relaxed hand; stays free, nothing trips; tried up to 50 mm"},
            {0.01, kMilli * kDeepest_m},
            [=](double depth_mm) {
                PressedCorner corner(which);
                corner.press(2.0);
                const Vector3 top_m = corner.last.tip_m + Vector3(0.0, depth_mm / kMilli, 0.0);
                const contact::HapticSurface block(
                    rig::solid_box(top_m - Vector3(kHalfBlock_m, 2.0 * kHalfBlock_m, kHalfBlock_m),
                                   top_m + Vector3(kHalfBlock_m, 0.0, kHalfBlock_m)));
                corner.inputs.surface = &block;
                ++corner.inputs.scene_id;
                return !ticks_until(corner, 300, [&] {
                    return corner.last.contact.touching || corner.has_tripped();
                });
            }};
}

Experiment silent_window(const loops::StabilityCase &which) {
    return {.row = {kServoMethod, "window silent for longer than", "s", "its heartbeat stops",
                    which.device.limits.window_silence_s},
            .reading = [=]() -> std::optional<double> {
                PressedCorner corner(which, 0.0);
                corner.inputs.heartbeat = 7;
                corner.tick(); // the last heartbeat
                const std::optional<double> ticks =
                    ticks_until(corner, 100'000, [&] { return corner.has_tripped(); });
                return ticks ? std::optional(*ticks * which.period_s) : std::nullopt;
            }};
}

// When a pressing hand releases the device, the contact expels the tip. The force from which on
// that trips the limit of tip speed.

long ticks_in(double time_s, const loops::StabilityCase &which) {
    return std::lround(time_s / which.period_s);
}

/// K_x = α k̄ (27) where all motors are equal.
double tip_stiffness_N_per_m(const loops::StabilityCase &which) {
    const double alpha =
        control::alpha_bound(device::motor_jacobian(which.device.geometry, which.q_rad),
                             control::relative_stiffness(which.device));
    return alpha * control::mean_static_stiffness_Nm_per_rad(which.device, which.tuning);
}

/// The maximum speed of the tip per newton of the pressing force, by the linear loop without a
/// hand: from rest in a corner until it has left all three walls [m/s/N].
double speed_per_force(const loops::StabilityCase &which) {
    constexpr double kContact_s = 0.2; // the tip has left the walls by then
    loops::StabilityCase alone = which;
    alone.hands = {loops::no_hand()};
    const loops::LoopMember member = loops::members(alone).front();
    const loops::SampledLaw law = loops::sampled_law(alone, member);
    const Eigen::MatrixXd map = loops::linear_loop(alone, member).one_period_map(law);
    const Matrix3 J = device::motor_jacobian(which.device.geometry, which.q_rad);
    const Vector3 pressed_m =
        -Vector3::Constant(1.0 / std::sqrt(3.0)) / tip_stiffness_N_per_m(which);
    Eigen::VectorXd state = Eigen::VectorXd::Zero(map.rows());
    const loops::StateStarts at(3, 3);
    const auto of = [&state](Eigen::Index start) { return state.segment<3>(start); };
    of(at.position) = J.inverse() * pressed_m;
    const Matrix3 per_position = law.per_position;
    of(at.current) = per_position * (J.inverse() * pressed_m) / which.tuning.dR_Ohm;
    double maximum = 0.0;
    for (long tick = 0; tick < ticks_in(kContact_s, which); ++tick) {
        state = map * state;
        maximum = std::max(maximum, Vector3(J * of(at.rate)).norm());
        if (Vector3(J * of(at.position)).minCoeff() > 0.0) {
            break;
        }
    }
    return maximum;
}

bool keeps_running(const loops::StabilityCase &which, double force_N, double limit_m_per_s) {
    constexpr double kHand_N = 40.0; // the maximum force with which it presses
    constexpr double kWatched_s = 0.3;
    const double K = tip_stiffness_N_per_m(which);
    const double hand_N_per_m = which.hands.front().stiffness_N_per_m;
    PressedCorner corner(which, kHand_N);
    corner.inputs.limits.tip_speed_m_per_s = limit_m_per_s;
    corner.press(force_N * (K + hand_N_per_m) / K); // hand and contact are two springs in series
    if (corner.has_tripped()) {
        return false;
    }
    corner.let_go();
    for (long tick = 0; tick < ticks_in(kWatched_s, which); ++tick) {
        corner.tick();
    }
    return !corner.has_tripped();
}

Experiment release(const loops::StabilityCase &which, double limit_m_per_s,
                   const std::string &setting) {
    constexpr double kMax_N = 7.0; // less than the limiter's maximum
    const double predicted_N = limit_m_per_s / speed_per_force(which);
    return {{kServoMethod, "hand released while pressing with more than", "N", setting,
             predicted_N < kMax_N ? std::optional(predicted_N) : std::nullopt},
            {0.5, kMax_N, false, 1e-4},
            [=](double force_N) { return keeps_running(which, force_N, limit_m_per_s); }};
}

} // namespace

PressedCorner::PressedCorner(const loops::StabilityCase &which, double hand_force_N)
    : PressedCorner(which,
                    rig::corner_scenario(setting_of(which),
                                         simulated_hand(which.hands.front(), hand_force_N))) {}

PressedCorner::PressedCorner(const loops::StabilityCase &which, const rig::Scenario &scenario)
    : ServoRig(scenario), hand_N_per_m_(which.hands.front().stiffness_N_per_m),
      corner_m_(device::tip_position_m(which.device.geometry, which.q_rad)),
      target_m_(scenario.start_m) {
    run(scenario.duration_s);
}

void PressedCorner::press(double force_N) {
    constexpr double kSettles_s = 0.6;
    target_m_ = corner_m_ - Vector3::Constant(force_N / hand_N_per_m_ / std::sqrt(3.0));
    phantom().set_hand_target(target_m_);
    run(kSettles_s);
}

void PressedCorner::nudge() {
    constexpr double kNudge_m = 1e-4;
    target_m_ += kNudge_m * Vector3(0.6, 0.64, 0.48);
    phantom().set_hand_target(target_m_);
}

double late_ticks_eigenvalue(const loops::StabilityCase &which, const loops::LoopMember &member,
                             int missed) {
    SPRINGDRIVE_ASSERT(which.delay_periods == 0.0);
    const loops::DrivenLoad load = loops::driven_load(which, member);
    SPRINGDRIVE_ASSERT_AUDIT(loops::pulls_on_all_positions(
        loops::sampled_law(which, member).per_position, load.stiffness_Nm_per_rad));
    const double T = which.period_s;
    // A tick differentiates the motion since the last one over the time since the last one.
    const auto law = [&](int periods) {
        loops::StabilityCase at = which;
        at.period_s = periods * T;
        return loops::sampled_law(at, member);
    };
    // Each tick's command is held until the next one.
    const Eigen::MatrixXd until_late =
        loops::one_period_map(loops::sampled_load(load, (1 + missed) * T), law(1));
    const Eigen::MatrixXd until_on_time =
        loops::one_period_map(loops::sampled_load(load, T), law(1 + missed));
    return eigenvalues(until_on_time * until_late).cwiseAbs().maxCoeff();
}

Experiments servo_experiments(const loops::StabilityCase &which) {
    constexpr double kLowered_m_per_s = 0.2;
    const loops::StabilityCase held = firm_in_a_hand(which, 0.5);
    const loops::StabilityCase pressed = firm_in_a_hand(which, 1.0);
    const double limit_m_per_s = which.device.limits.tip_speed_m_per_s;
    return {
        new_scene(held),
        late_tick(held),
        every_other_tick_late(held),
        late_answers(held),
        lost_device(held),
        missing_answers(held),
        volts_off(held),
        silent_window(held),
        release(pressed, limit_m_per_s,
                "tuning firm, tip speed limited to " + with_unit(limit_m_per_s, "m/s") +
                    "; tried up to 7 N"),
        release(pressed, kLowered_m_per_s,
                "tuning firm, tip speed limit lowered to " + with_unit(kLowered_m_per_s, "m/s"))};
}

} // namespace springdrive::limits

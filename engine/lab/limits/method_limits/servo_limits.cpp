#include "engine/lab/limits/method_limits/limit_trials.h"

#include "engine/lab/limits/method_limits/late_ticks.h"
#include "engine/lab/limits/method_limits/pressed_corner.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/servo/deadlines.h"

#include <algorithm>
#include <cmath>

namespace springdrive::limits {

namespace {

constexpr const char *kServoMethod = "servo";
constexpr double kMilli = 1e3;

/// Tuning firm, all motors, one relaxed hand.
loops::StabilityCase firm_in_a_hand(const loops::StabilityCase &which) {
    loops::StabilityCase firm = which;
    firm.tuning = control::Tuning{};
    firm.freedom = loops::Freedom::three_motors;
    firm.hands = {loops::hand_of_firmness(0.5)};
    firm.delay_periods = 0;
    return firm;
}

/// The number of consecutive missed deadlines that the monitor tolerates.
int missed_limit(const loops::StabilityCase &which) {
    return static_cast<int>(std::floor(which.device.limits.late_s / which.period_s + 1e-6));
}

/// One tick is late. From limit + 1 periods on, the monitor trips.
LimitTrial late_tick(const loops::StabilityCase &which) {
    const double period_ms = kMilli * which.period_s;
    const int limit = missed_limit(which);
    LimitTrial trial{
        {kServoMethod,
         "a tick later than",
         "ms",
         "1 kHz; it stops at more than " + with_unit(limit, "missed deadlines in a row"),
         period_ms * (limit + 1),
         {},
         {}},
        0.1 * period_ms,
        10.0 * period_ms * (limit + 1),
        false,
        [=](double late_ms) {
            PressedCorner corner(which, 0.0);
            servo::Deadlines deadlines(1.0 / which.period_s);
            deadlines.begin(deadlines.next_ns() + std::llround(1e6 * late_ms));
            corner.late_tick(static_cast<int>(deadlines.missed()));
            return !corner.has_tripped();
        }};
    trial.resolution = 1e-5;
    return trial;
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
LimitTrial every_other_tick_late(const loops::StabilityCase &which) {
    const int maximum = missed_limit(which);
    int predicted = 0;
    while (predicted < maximum &&
           late_ticks_eigenvalue(which, loops::members(which).front(), predicted + 1) < 1.0) {
        ++predicted;
    }
    return {{kServoMethod,
             "every other tick later than",
             "periods",
             "tuning firm, 1 kHz, pressed into a corner by a relaxed hand",
             static_cast<double>(predicted),
             {},
             {}},
            0.0,
            static_cast<double>(maximum),
            true,
            [=](double missed) { return motion_decays(which, static_cast<int>(missed)); }};
}

/// Late answers increase d by whole periods, as USB frames that miss their tick do.
LimitTrial late_answers(const loops::StabilityCase &which) {
    const auto delayed = [=](int periods) {
        loops::StabilityCase late = which;
        late.tuning.K_P_V_per_rad = 20.0;
        late.delay_periods = periods;
        return late;
    };
    int predicted = 0;
    while (predicted < simulated::SimulationOptions::kMaxDelay &&
           loops::is_stable(delayed(predicted + 1))) {
        ++predicted;
    }
    return {{kServoMethod,
             "answers later than",
             "periods",
             "K_P 20 V/rad, 1 kHz, pressed into a corner by a relaxed hand",
             static_cast<double>(predicted),
             {},
             {}},
            0.0,
            static_cast<double>(simulated::SimulationOptions::kMaxDelay),
            true,
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
LimitTrial lost_device(const loops::StabilityCase &which) {
    return {{kServoMethod,
             "device lost for more ticks than",
             "–",
             "for example unplugged; no command can reach it",
             0.0,
             {},
             {}},
            0.0,
            10.0,
            true,
            [=](double lost) { return survives(which, device::FaultKind::unplug, lost); }};
}

/// The servo waits for a silent device until the budget is exhausted; the last command stays
/// active.
LimitTrial missing_answers(const loops::StabilityCase &which) {
    const double budget = which.device.limits.stale_s / which.period_s;
    return {{kServoMethod,
             "measurements missing in a row, more than",
             "–",
             "1 kHz; the last command stays active meanwhile",
             std::floor(budget + 1e-6),
             {},
             {}},
            0.0,
            3.0 * budget,
            true,
            [=](double missing) { return survives(which, device::FaultKind::drop, missing); }};
}

/// The tick that detects the loss commands braking before it ends.
LimitTrial volts_off(const loops::StabilityCase &which) {
    LimitTrial trial;
    trial.line = {kServoMethod,
                  "voltage off after",
                  "periods",
                  "the device is lost while a relaxed hand presses",
                  0.0,
                  {},
                  {}};
    trial.reading = [=]() -> std::optional<double> {
        PressedCorner corner(which);
        corner.press(2.0);
        corner.device().commit({.kind = device::FaultKind::unplug});
        for (int ticks = 0; ticks < 100; ++ticks) {
            corner.tick();
            if (corner.device().last_command().e_W_V.isZero(0.0)) {
                return ticks;
            }
        }
        return std::nullopt;
    };
    return trial;
}

/// A tip that is inside a block after a change of scene is free until it has left.
LimitTrial new_scene(const loops::StabilityCase &which) {
    constexpr double kHalfBlock_m = 0.1;
    constexpr double kDeepest_m = 0.05;
    return {{"proxy",
             "scene switched in contact, inside deeper than",
             "mm",
             "pressed by a relaxed hand; stays free, nothing trips; tried up to 50 mm",
             {},
             {},
             {}},
            0.01,
            kMilli * kDeepest_m,
            false,
            [=](double depth_mm) {
                PressedCorner corner(which);
                corner.press(2.0);
                const Vector3 top_m = corner.last.tip_m + Vector3(0.0, depth_mm / kMilli, 0.0);
                const contact::HapticSurface block(
                    rig::solid_box(top_m - Vector3(kHalfBlock_m, 2.0 * kHalfBlock_m, kHalfBlock_m),
                                   top_m + Vector3(kHalfBlock_m, 0.0, kHalfBlock_m)));
                corner.inputs.surface = &block;
                ++corner.inputs.scene_id;
                for (int i = 0; i < 300; ++i) {
                    if (corner.tick().contact.touching || corner.has_tripped()) {
                        return false;
                    }
                }
                return true;
            }};
}

LimitTrial silent_window(const loops::StabilityCase &which) {
    LimitTrial trial;
    trial.line = {kServoMethod,
                  "window silent for longer than",
                  "s",
                  "its heartbeat stops",
                  which.device.limits.window_silence_s,
                  {},
                  {}};
    trial.reading = [=]() -> std::optional<double> {
        PressedCorner corner(which, 0.0);
        corner.inputs.heartbeat = 7;
        corner.tick(); // the last heartbeat
        for (long ticks = 1; ticks < 100'000; ++ticks) {
            if (corner.tick(); corner.has_tripped()) {
                return static_cast<double>(ticks - 1) * which.period_s;
            }
        }
        return std::nullopt;
    };
    return trial;
}

} // namespace

std::vector<LimitTrial> servo_trials(const loops::StabilityCase &which) {
    const loops::StabilityCase firm = firm_in_a_hand(which);
    return {new_scene(firm),    late_tick(firm),    every_other_tick_late(firm),
            late_answers(firm), lost_device(firm),  missing_answers(firm),
            volts_off(firm),    silent_window(firm)};
}

} // namespace springdrive::limits

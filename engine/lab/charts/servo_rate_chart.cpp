#include "engine/lab/charts/servo_rate_chart.h"

#include "base/degrees.h"
#include "base/input_error.h"
#include "base/timing.h"
#include "engine/control/motion_control.h"
#include "engine/control/rendered_force.h"
#include "engine/control/tuning.h"
#include "engine/lab/charts/charts.h"
#include "engine/lab/loops/link_plane.h"
#include "engine/lab/loops/rendered_stiffness.h"
#include "engine/lab/loops/stability_case.h"
#include "engine/lab/rig/scenario/scenarios.h"
#include "engine/lab/rig/servo_rig.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

namespace springdrive::charts {

namespace {

constexpr std::array<int, 7> kRates_Hz{250, 500, 1000, 2000, 4000, 10'000, 20'000};

constexpr int kFrequencies = 12; ///< of the sweep at each rate
constexpr double kMinJudged_Hz = 2.0;
constexpr double kMaxJudged_Hz = 100.0;

Cost per_millisecond(const Cost &tick, int rate_Hz) {
    const double ticks = 1e-3 * rate_Hz;
    return {ticks * tick.min_ns, ticks * tick.median_ns, ticks * tick.max_ns};
}

/// "4 kHz", "250 Hz".
std::string rate_text(int rate_Hz) {
    return rate_Hz < 1000 ? std::to_string(rate_Hz) + " Hz"
                          : std::to_string(rate_Hz / 1000) + " kHz";
}

constexpr const char *kCostLabel =
    "processor time per millisecond of servo (10 µs are 1 % of a processor)";

/// λ, clamped to its range.
double scaled_lambda(const control::Tuning &tuning, double factor) {
    const control::Parameter &parameter = control::parameter_of(&control::Tuning::lambda_rad_per_s);
    return std::clamp(factor * tuning.lambda_rad_per_s, parameter.minimum, parameter.maximum);
}

constexpr double kPeriod_s = 1e-3; ///< of the timed servo
constexpr std::size_t kTicks = 8000;

/// Joint angles in the middle of the workspace.
Vector3 middle_angles_rad(const device::DeviceDescription &device) {
    return device::joint_angles_rad(device.geometry, device.workspace.centre_m)
        .value_or(Vector3::Zero());
}

/// The servo's measurements, tick by tick.
std::vector<device::Measurement> recorded_states(rig::ServoRig &rig) {
    std::vector<device::Measurement> states;
    for (std::size_t i = 0; i < kTicks; ++i) {
        if (rig.tick(); rig.has_tripped()) {
            throw InputError("the safety monitor stopped the servo while it was timed: " +
                             servo::description(rig.last.safety) + "; choose another tuning");
        }
        states.push_back(rig.measured());
    }
    return states;
}

} // namespace

double stiffness_error(const loops::SpringDrive &drive, int points) {
    double sum = 0.0;
    const double ratio = kMaxJudged_Hz / kMinJudged_Hz;
    for (int i = 0; i < points; ++i) {
        const double requested_Hz = kMinJudged_Hz * std::pow(ratio, i / (points - 1.0));
        const loops::SweepWindow window = loops::sweep_window(requested_Hz, drive.period_s);
        const double omega_rad_per_s = 2.0 * std::numbers::pi * window.frequency_hz(drive.period_s);
        const std::complex<double> truth = loops::analytic_stiffness(drive, omega_rad_per_s);
        sum += std::norm((loops::measured_stiffness(drive, window) - truth) / truth);
    }
    return std::sqrt(sum / points);
}

double perceived_direction_error_rad(const device::DeviceDescription &device,
                                     const control::Tuning &tuning, double period_s) {
    const Vector3 q_rad = middle_angles_rad(device);
    const loops::PlanarContact contact = loops::planar_contact(
        device, tuning, q_rad, loops::planar_stiffness(device, tuning, q_rad).alpha_rad2_per_m2,
        {period_s, 0.0});
    return loops::worst_direction_error_rad(loops::tip_stiffness(
        contact, control::MotionMap::transpose, 2.0 * std::numbers::pi * control::kPerceived_Hz));
}

bool is_stable_on_all_motors(const device::DeviceDescription &device, const control::Tuning &tuning,
                             double period_s, double delay_periods) {
    loops::StabilityCase each = loops::motors_alone(device, tuning);
    each.period_s = period_s;
    each.delay_periods = delay_periods;
    return loops::is_stable(each);
}

Cost cost_of_servo_tick(const ChartSetting &setting) {
    const rig::ScenarioSetting of_setting{setting.device, setting.tuning};
    rig::ServoRig rig(rig::scripted_touch_scenario(of_setting, rig::placed_sphere()));
    rig.inputs.global_alpha_rad2_per_m2 = control::global_alpha_bound(setting.device);
    const std::vector<device::Measurement> states = recorded_states(rig);
    return cost_of(setting.repeats, static_cast<double>(states.size()), [&] {
        servo::ServoLoop loop(rig.phantom(), kPeriod_s);
        for (const device::Measurement &state : states) {
            keep(loop.update(state, rig.inputs));
        }
    });
}

SpeedAccuracyChart servo_rate_stiffness_chart(const ChartSetting &setting,
                                              const ChartProgress &progress) {
    SpeedAccuracyChart chart{"servo_rate_stiffness",
                             "Servo rate: rendered stiffness against (12), " + setting.device.name,
                             kCostLabel,
                             "relative error of K_θ from 2 to 100 Hz, rms",
                             {}};
    const Cost tick = cost_of_servo_tick(setting);
    double done = 0.0;
    for (const int delay : {0, 1, 2}) {
        const std::string method =
            delay == 0 ? "no delay"
                       : std::to_string(delay) + (delay == 1 ? " sample late" : " samples late");
        for (const int rate_Hz : kRates_Hz) {
            const loops::SpringDrive drive{setting.device.motor[1], setting.tuning, 1.0 / rate_Hz,
                                           static_cast<double>(delay)};
            chart.points.push_back(
                {method, rate_text(rate_Hz), per_millisecond(tick, rate_Hz),
                 stiffness_error(drive, kFrequencies),
                 is_stable_on_all_motors(setting.device, setting.tuning, drive.period_s, delay)});
            progress(++done / (3.0 * kRates_Hz.size()));
        }
    }
    return chart;
}

SpeedAccuracyChart servo_rate_direction_chart(const ChartSetting &setting,
                                              const ChartProgress &progress) {
    SpeedAccuracyChart chart{"servo_rate_direction",
                             fmt::format("Servo rate: direction of the force at {:g} Hz, {}",
                                         control::kPerceived_Hz, setting.device.name),
                             kCostLabel,
                             fmt::format("largest angle from normal to force at {:g} Hz (degrees)",
                                         control::kPerceived_Hz),
                             {}};
    const Cost tick = cost_of_servo_tick(setting);
    double done = 0.0;
    for (const double factor : {1.0 / 3.0, 1.0, 3.0}) {
        control::Tuning tuning = setting.tuning;
        tuning.lambda_rad_per_s = scaled_lambda(setting.tuning, factor);
        const std::string method =
            "λ " + std::to_string(std::lround(tuning.lambda_rad_per_s)) + " rad/s";
        for (const int rate_Hz : kRates_Hz) {
            const double period_s = 1.0 / rate_Hz;
            const double error_rad =
                perceived_direction_error_rad(setting.device, tuning, period_s);
            chart.points.push_back({method, rate_text(rate_Hz), per_millisecond(tick, rate_Hz),
                                    error_rad * kDegreesPerRadian,
                                    is_stable_on_all_motors(setting.device, tuning, period_s, 0)});
        }
        progress(++done / 3.0);
    }
    return chart;
}

} // namespace springdrive::charts

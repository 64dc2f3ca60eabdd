#include "engine/lab/charts/servo_rate_chart.h"

#include "base/degrees.h"
#include "engine/control/parameters.h"
#include "engine/control/perception.h"
#include "engine/lab/charts/servo_rate_trial.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace springdrive::charts {

namespace {

constexpr std::array<int, 7> kRates_Hz{250, 500, 1000, 2000, 4000, 10'000, 20'000};

constexpr int kFrequencies = 12; ///< of the sweep at each rate

rig::Cost per_millisecond(const rig::Cost &tick, int rate_Hz) {
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
    const auto parameter = std::ranges::find(
        control::kParameters, &control::Tuning::lambda_rad_per_s, &control::Parameter::value);
    return std::clamp(factor * tuning.lambda_rad_per_s, parameter->minimum, parameter->maximum);
}

} // namespace

rig::SpeedAccuracyChart servo_rate_stiffness_chart(const ChartSetting &setting,
                                                   const ChartProgress &progress) {
    rig::SpeedAccuracyChart chart;
    chart.name = "servo_rate_stiffness";
    chart.title = "Servo rate: rendered stiffness against (12), " + setting.device.name;
    chart.cost_label = kCostLabel;
    chart.error_label = "relative error of K_θ from 2 to 100 Hz, rms";
    const rig::Cost tick = cost_of_servo_tick(setting);
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

rig::SpeedAccuracyChart servo_rate_direction_chart(const ChartSetting &setting,
                                                   const ChartProgress &progress) {
    rig::SpeedAccuracyChart chart;
    chart.name = "servo_rate_direction";
    chart.title = fmt::format("Servo rate: direction of the force at {:g} Hz, {}",
                              control::kPerceived_Hz, setting.device.name);
    chart.cost_label = kCostLabel;
    chart.error_label = fmt::format("largest angle from normal to force at {:g} Hz (degrees)",
                                    control::kPerceived_Hz);
    const rig::Cost tick = cost_of_servo_tick(setting);
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

#include "app/figures/locked_figures.h"

#include "app/figures/figure_text.h"

#include <algorithm>
#include <string>

namespace springdrive::app {

namespace {

double harmless_m(const FigureSetting &setting, control::MotionMap map) {
    return limits::harmless_penetration_m(setting.device, setting.tuning, setting.q_rad, map);
}

} // namespace

limits::LockedDeviceOptions locked_options(const FigureSetting &setting, control::MotionMap map,
                                           Locked how) {
    constexpr double kLinear_m = 1e-4; // bends the inverse map's force by Δx/l, 0.04°
    limits::LockedDeviceOptions options;
    options.q_rad = setting.q_rad;
    options.tuning = setting.tuning;
    options.servo_period_s = setting.servo_period_s;
    options.penetration_m = harmless_m(setting, map);
    options.device_seed = setting.device_seed;
    options.observes_resistance = how == Locked::observed;
    if (how == Locked::ideal) {
        options.effects = false;
        options.penetration_m = std::min(options.penetration_m, kLinear_m);
    }
    return options;
}

double common_penetration_m(const FigureSetting &setting) {
    return std::min(harmless_m(setting, control::MotionMap::inverse),
                    harmless_m(setting, control::MotionMap::transpose));
}

std::string conditions_text(const FigureSetting &setting) {
    return "measured on simulated device " + std::to_string(setting.device_seed) +
           ": R ±5 %, k_T ±3 %, ripple 2 %, 12-bit current, encoders, friction, weight, heat";
}

std::string penetration_text(double penetration_m) {
    return number_text(1e3 * penetration_m, 2) + " mm";
}

} // namespace springdrive::app

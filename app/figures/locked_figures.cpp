#include "app/figures/locked_figures.h"

#include "app/figures/figure_text.h"

#include <algorithm>

namespace springdrive::app {

limits::LockedDeviceOptions with_effects(const FigureSetting &setting, control::MotionMap map) {
    limits::LockedDeviceOptions options;
    options.q_rad = setting.q_rad;
    options.tuning = setting.tuning;
    options.servo_period_s = setting.servo_period_s;
    options.resistance_spread = setting.resistance_spread;
    options.penetration_m =
        limits::harmless_penetration_m(setting.device, setting.tuning, setting.q_rad, map);
    return options;
}

limits::LockedDeviceOptions without_effects(const FigureSetting &setting, control::MotionMap map) {
    constexpr double kLinear_m = 1e-4; // bends the inverse map's force by Δx/l, 0.04°
    limits::LockedDeviceOptions options = with_effects(setting, map);
    options.effects = false;
    options.penetration_m = std::min(options.penetration_m, kLinear_m);
    return options;
}

std::string effects_text(const limits::LockedDeviceOptions &options) {
    return "with encoders, weight, friction, warming windings, R of motors 2 and 3 at ∓" +
           number_text(100.0 * options.resistance_spread, 2) + " %";
}

std::string penetration_text(const limits::LockedDeviceOptions &options) {
    return number_text(1e3 * options.penetration_m, 2) + " mm";
}

} // namespace springdrive::app

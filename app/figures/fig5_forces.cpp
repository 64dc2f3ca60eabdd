// Fig. 5 of the paper.
#include "app/figures/figure_text.h"
#include "app/figures/locked_figures.h"
#include "engine/control/tuning.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

namespace springdrive::app {

Figure forces_figure(const FigureSetting &setting, const FigureProgress &progress) {
    constexpr double kDown_rad = -0.5 * std::numbers::pi; // a wall above the device
    const double penetration_m = common_penetration_m(setting);
    Figure figure;
    figure.numbers = Table::with_columns(
        "map,penetration_mm,measured_outward_N,measured_up_N,predicted_outward_N,predicted_up_N,"
        "correct_outward,correct_up,error_deg,predicted_error_deg,unobserved_outward_N,"
        "unobserved_up_N,unobserved_error_deg",
        kFigureFormat);
    double longest_N = 0.0;
    for (const control::MotionMap map :
         {control::MotionMap::inverse, control::MotionMap::transpose}) {
        const std::string name(control::name_of(map));
        const auto pressed = [&](Locked how) {
            limits::LockedDeviceOptions options = locked_options(setting, map, how);
            options.penetration_m = penetration_m;
            return limits::press_locked_device(setting.device, options, map, kDown_rad);
        };
        const limits::LockedForce force = pressed(Locked::observed);
        const limits::LockedForce unobserved = pressed(Locked::unobserved);
        figure.numbers.rows.push_back(
            {name, 1e3 * penetration_m, force.measured_N.x(), force.measured_N.y(),
             force.predicted_N.x(), force.predicted_N.y(), 0.0, -1.0,
             kDegreesPerRadian * force.error_rad, kDegreesPerRadian * force.predicted_error_rad,
             unobserved.measured_N.x(), unobserved.measured_N.y(),
             kDegreesPerRadian * unobserved.error_rad});
        const auto off_text = [](double error_rad) {
            return number_text(kDegreesPerRadian * std::abs(error_rad), 3) + "° off";
        };
        figure.marks.add(name + "_text", off_text(force.error_rad));
        figure.marks.add(name + "_unobserved_text", off_text(unobserved.error_rad));
        longest_N = std::max({longest_N, force.measured_N.norm(), force.predicted_N.norm(),
                              unobserved.measured_N.norm()});
        progress(map == control::MotionMap::inverse ? 0.5 : 1.0);
    }
    figure.marks.add("heading",
                     "Fig. 5: forces against a horizontal wall above, " + setting.device.name);
    figure.marks.add("setting", angles_text(setting) + "; " + tuning_text(setting));
    figure.marks.add("conditions", conditions_text(setting));
    figure.marks.add("penetration", penetration_text(penetration_m));
    figure.marks.add("longest_N", longest_N);
    return figure;
}

} // namespace springdrive::app

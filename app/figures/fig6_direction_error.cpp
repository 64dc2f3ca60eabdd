// Fig. 6 of the paper.
#include "app/figures/figure_text.h"
#include "app/figures/locked_figures.h"
#include "engine/lab/loops/stiffness_ellipse.h"

#include <numbers>
#include <string>

namespace springdrive::app {

namespace {

double error_deg(const FigureSetting &setting, control::MotionMap map, Locked how,
                 double normal_rad) {
    return kDegreesPerRadian * limits::press_locked_device(setting.device,
                                                           locked_options(setting, map, how), map,
                                                           normal_rad)
                                   .error_rad;
}

ChartMarks marks(const FigureSetting &setting, const loops::PlanarStiffness &stiffness) {
    const auto depth_text = [&](control::MotionMap map) {
        return penetration_text(locked_options(setting, map, Locked::observed).penetration_m);
    };
    ChartMarks marks;
    marks.add("heading", "Fig. 6: direction error of the force, " + setting.device.name);
    marks.add("setting", angles_text(setting) + "; " + tuning_text(setting));
    marks.add("conditions", conditions_text(setting));
    marks.add("inverse_penetration", depth_text(control::MotionMap::inverse));
    marks.add("transpose_penetration", depth_text(control::MotionMap::transpose));
    // The prediction as a curve, also between the surfaces.
    marks.add("K_xx", stiffness.inverse(0, 0));
    marks.add("K_xy", stiffness.inverse(0, 1));
    marks.add("K_yy", stiffness.inverse(1, 1));
    return marks;
}

} // namespace

Figure direction_error_figure(const FigureSetting &setting, const FigureProgress &progress) {
    constexpr int kSurfaces = 24;
    const loops::PlanarStiffness stiffness =
        loops::planar_stiffness(setting.device, setting.tuning, setting.q_rad);
    Figure figure;
    figure.numbers = Table::with_columns(
        "normal_deg,inverse_error_deg,transpose_error_deg,inverse_predicted_deg,inverse_ideal_deg,"
        "transpose_ideal_deg,inverse_unobserved_deg,transpose_unobserved_deg",
        kFigureFormat);
    for (int i = 0; i < kSurfaces; ++i) {
        const double normal_rad = 2.0 * std::numbers::pi * i / kSurfaces;
        const auto inverse_deg = [&](Locked how) {
            return error_deg(setting, control::MotionMap::inverse, how, normal_rad);
        };
        const auto transpose_deg = [&](Locked how) {
            return error_deg(setting, control::MotionMap::transpose, how, normal_rad);
        };
        figure.numbers.rows.push_back(
            {kDegreesPerRadian * normal_rad, inverse_deg(Locked::observed),
             transpose_deg(Locked::observed),
             kDegreesPerRadian * loops::inverse_direction_error_rad(stiffness, normal_rad),
             inverse_deg(Locked::ideal), transpose_deg(Locked::ideal),
             inverse_deg(Locked::unobserved), transpose_deg(Locked::unobserved)});
        progress((i + 1.0) / kSurfaces);
    }
    figure.marks = marks(setting, stiffness);
    return figure;
}

} // namespace springdrive::app

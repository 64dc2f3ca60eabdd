// Fig. 6 of the paper.
#include "app/figures/figure_text.h"
#include "app/figures/locked_figures.h"
#include "engine/lab/loops/stiffness_ellipse.h"

#include <numbers>
#include <string>

namespace springdrive::app {

namespace {

/// The measurements against one surface, with both maps.
struct Errors {
    double inverse_deg = 0.0;
    double transpose_deg = 0.0;
};

using Conditions = limits::LockedDeviceOptions (*)(const FigureSetting &, control::MotionMap);

Errors errors_against(const FigureSetting &setting, Conditions conditions, double normal_rad) {
    const auto error_deg = [&](control::MotionMap map) {
        return kDegreesPerRadian * limits::press_locked_device(
                                       setting.device, conditions(setting, map), map, normal_rad)
                                       .error_rad;
    };
    return {error_deg(control::MotionMap::inverse), error_deg(control::MotionMap::transpose)};
}

ChartMarks marks(const FigureSetting &setting, const loops::PlanarStiffness &stiffness) {
    const limits::LockedDeviceOptions inverse = with_effects(setting, control::MotionMap::inverse);
    const limits::LockedDeviceOptions transpose =
        with_effects(setting, control::MotionMap::transpose);
    ChartMarks marks;
    marks.add("heading", "Fig. 6: direction error of the force, " + setting.device.name);
    marks.add("setting", angles_text(setting) + "; " + tuning_text(setting));
    marks.add("conditions", effects_text(inverse));
    marks.add("inverse_penetration", penetration_text(inverse));
    marks.add("transpose_penetration", penetration_text(transpose));
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
    figure.csv = "normal_deg,inverse_error_deg,transpose_error_deg,inverse_predicted_deg,"
                 "inverse_ideal_deg,transpose_ideal_deg\n";
    for (int i = 0; i < kSurfaces; ++i) {
        const double normal_rad = 2.0 * std::numbers::pi * i / kSurfaces;
        const Errors real = errors_against(setting, with_effects, normal_rad);
        const Errors ideal = errors_against(setting, without_effects, normal_rad);
        figure.csv +=
            csv_line({kDegreesPerRadian * normal_rad, real.inverse_deg, real.transpose_deg,
                      kDegreesPerRadian * loops::inverse_direction_error_rad(stiffness, normal_rad),
                      ideal.inverse_deg, ideal.transpose_deg});
        progress((i + 1.0) / kSurfaces);
    }
    figure.marks = marks(setting, stiffness);
    return figure;
}

} // namespace springdrive::app

// Fig. 3 of the paper.
#include "app/figures/figure_text.h"
#include "app/figures/locked_figures.h"
#include "base/eigenvalues.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/loops/stiffness_ellipse.h"

#include <cmath>
#include <string>

namespace springdrive::app {

namespace {

/// The largest of 1, 2 and 5 times a power of ten that is not above `number`.
double round_number_below(double number) {
    const double decade = std::pow(10.0, std::floor(std::log10(number)));
    const double share = number / decade;
    return decade * (share >= 5.0 ? 5.0 : share >= 2.0 ? 2.0 : 1.0);
}

/// The linkage in millimetres, outward and up from the base joint.
void add_linkage(ChartMarks &marks, const FigureSetting &setting) {
    constexpr double kMillimetres = 1e3;
    const device::LinkagePose pose = device::linkage_pose(setting.device.geometry, setting.q_rad);
    const auto add = [&](const std::string &name, const Vector3 &point_m) {
        const loops::Vector2 in_plane =
            loops::link_plane(setting.q_rad[0]).transpose() * (point_m - pose.base_m);
        marks.add(name + "_x", kMillimetres * in_plane.x());
        marks.add(name + "_y", kMillimetres * in_plane.y());
    };
    add("elbow", pose.elbow_m);
    add("tip", pose.tip_m);
    add("crank", pose.crank_m);
    add("coupling", pose.coupling_m);
}

/// The chart's scale of stiffness: the longest axis is about as long as the links.
void add_scale(ChartMarks &marks, const FigureSetting &setting,
               const loops::PlanarStiffness &stiffness) {
    const loops::Vector2 along_axes = symmetric_modes(stiffness.inverse).eigenvalues;
    const double longest_N_per_m = along_axes.maxCoeff();
    const double link_mm = 0.6e3 * setting.device.geometry.upper_arm_m;
    const double bar_N_per_m = round_number_below(0.6 * longest_N_per_m);
    marks.add("mm_per_N_per_m", link_mm / longest_N_per_m);
    marks.add("bar_N_per_m", bar_N_per_m);
    marks.add("bar_text", number_text(1e-3 * bar_N_per_m, 3) + " N/mm");
    marks.add("circle_text", number_text(1e-3 * stiffness.transpose(0, 0), 3));
    marks.add("longest_text", number_text(1e-3 * longest_N_per_m, 3));
    marks.add("shortest_text", number_text(1e-3 * along_axes.minCoeff(), 3));
    marks.add("alpha_text", number_text(stiffness.alpha_rad2_per_m2, 4));
}

/// The force on the vice per metre inside a surface with that normal [N/m].
loops::Vector2 measured_N_per_m(const FigureSetting &setting, control::MotionMap map,
                                double normal_rad) {
    const limits::LockedDeviceOptions options = locked_options(setting, map, Locked::observed);
    return limits::press_locked_device(setting.device, options, map, normal_rad).measured_N /
           options.penetration_m;
}

} // namespace

Figure ellipses_figure(const FigureSetting &setting, const FigureProgress &progress) {
    const loops::PlanarStiffness stiffness =
        loops::planar_stiffness(setting.device, setting.tuning, setting.q_rad);
    Figure figure;
    figure.numbers = Table::with_columns("angle_deg,inv_x,inv_y,trans_x,trans_y,inv_measured_x,"
                                         "inv_measured_y,trans_measured_x,trans_measured_y",
                                         kFigureFormat);
    constexpr int kPoints = 180;
    constexpr int kPointsToOneMeasured = 10;
    int point_number = 0;
    for (const loops::EllipsePoint &point : loops::stiffness_ellipses(stiffness, kPoints)) {
        loops::Vector2 inverse_N_per_m = loops::Vector2::Constant(NAN);
        loops::Vector2 transpose_N_per_m = inverse_N_per_m;
        if (point_number++ % kPointsToOneMeasured == 0) {
            inverse_N_per_m =
                measured_N_per_m(setting, control::MotionMap::inverse, point.angle_rad);
            transpose_N_per_m =
                measured_N_per_m(setting, control::MotionMap::transpose, point.angle_rad);
            progress(static_cast<double>(point_number) / kPoints);
        }
        figure.numbers.rows.push_back({kDegreesPerRadian * point.angle_rad,
                                       point.inverse_N_per_m.x(), point.inverse_N_per_m.y(),
                                       point.transpose_N_per_m.x(), point.transpose_N_per_m.y(),
                                       inverse_N_per_m.x(), inverse_N_per_m.y(),
                                       transpose_N_per_m.x(), transpose_N_per_m.y()});
    }
    figure.marks.add("heading", "Fig. 3: static tip stiffness, " + setting.device.name +
                                    " with its base locked");
    figure.marks.add("setting", angles_text(setting) + "; " + tuning_text(setting));
    figure.marks.add("conditions", conditions_text(setting));
    add_linkage(figure.marks, setting);
    add_scale(figure.marks, setting, stiffness);
    progress(1.0);
    return figure;
}

} // namespace springdrive::app

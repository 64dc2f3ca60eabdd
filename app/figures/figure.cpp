// Figures 2, 3, 5 and 6 of the paper, and figure 7, beyond it: high frequencies, which its section
// V discusses.
#include "app/figures/figure.h"

#include "base/degrees.h"
#include "base/eigenvalues.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/motion_control.h"
#include "engine/control/tuning.h"
#include "engine/lab/loops/link_plane.h"
#include "engine/lab/loops/rendered_stiffness.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <vector>

namespace springdrive::app {

namespace {

/// Of the figures' numbers, in the files.
constexpr const char *kFigureFormat = ".9g";

/// "1.234e-05": `digits` significant digits, no more than needed; empty for a NaN.
std::string number_text(double number, int digits) {
    return std::isnan(number) ? "" : fmt::format("{:.{}g}", number, digits);
}

/// dR, K_P, K_D and the servo, for a figure's second line: "dR 0.5 Ω, K_P 6 V/rad, …".
std::string gains_text(const FigureSetting &setting) {
    const control::Tuning &tuning = setting.tuning;
    return fmt::format("dR {:.4g} Ω, K_P {:.4g} V/rad, K_D {:.4g} V·s/rad, servo {:.4g} Hz",
                       tuning.dR_Ohm, tuning.K_P_V_per_rad, tuning.K_D_Vs_per_rad,
                       1.0 / setting.servo_period_s);
}

/// The same with λ.
std::string tuning_text(const FigureSetting &setting) {
    return fmt::format("{}, λ {:.4g} rad/s", gains_text(setting), setting.tuning.lambda_rad_per_s);
}

/// "q 0°, 20°, −15°".
std::string angles_text(const FigureSetting &setting) {
    std::string text = "q";
    for (Eigen::Index j = 0; j < 3; ++j) {
        const double angle_deg = kDegreesPerRadian * setting.q_rad[j];
        text += std::string(j == 0 ? " " : ", ") + (angle_deg < 0.0 ? "−" : "") +
                number_text(std::abs(angle_deg), 4) + "°";
    }
    return text;
}

double harmless_m(const FigureSetting &setting, control::MotionMap map) {
    return limits::harmless_penetration_m(setting.device, setting.tuning, setting.q_rad, map);
}

/// What is pressed against a surface in figures 3, 5 and 6.
enum class Locked : std::uint8_t {
    unobserved, ///< a drawn device with everything on; R̂ is set by the device file's R
    observed,   ///< the same, where R̂ follows the resistances that the servo observes
    ideal,      ///< as in the equations, pressed so little that their linearity in Δx holds
};

/// Pressed as deep as the device's limits permit with this map.
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

/// Title, angles and gains, and what is measured with the effects that are on.
void add_headings(ChartMarks &marks, const FigureSetting &setting, const std::string &heading) {
    marks.add("heading", heading);
    marks.add("setting", angles_text(setting) + "; " + tuning_text(setting));
    marks.add(
        "conditions",
        "measured on simulated device " + std::to_string(setting.device_seed) +
            ": R ±5 %, k_T ±3 %, ripple 2 %, 12-bit current, encoders, friction, weight, heat");
}

/// "1.2 mm"
std::string penetration_text(double penetration_m) {
    return number_text(1e3 * penetration_m, 2) + " mm";
}

constexpr int kPointsPerDecade = 20;
constexpr int kDecades = 4; ///< 1 Hz to 10 kHz: below R/L and above it

/// The highest frequency to be measured, relative to the servo rate; above one half there is
/// aliasing.
constexpr double kMaxMeasured = 0.45;

std::vector<Cell> row(const loops::SpringDrive &drive, double requested_hz) {
    const bool measurable = requested_hz * drive.period_s <= kMaxMeasured;
    const loops::SweepWindow window =
        measurable ? loops::sweep_window(requested_hz, drive.period_s) : loops::SweepWindow{};
    const double frequency_hz = measurable ? window.frequency_hz(drive.period_s) : requested_hz;
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    const std::complex<double> measured =
        measurable ? loops::measured_stiffness(drive, window) : std::complex<double>(kNone, kNone);

    const double omega = 2.0 * std::numbers::pi * frequency_hz;
    const std::complex<double> unmodified = loops::unmodified_stiffness(drive.motor, omega);
    const std::complex<double> analytic = loops::analytic_stiffness(drive, omega);
    const std::complex<double> sampled = loops::sampled_stiffness(drive, omega);
    return {frequency_hz,
            std::abs(unmodified),
            std::abs(analytic),
            std::abs(sampled),
            std::abs(measured),
            loops::phase_deg(unmodified),
            loops::phase_deg(analytic),
            loops::phase_deg(sampled),
            loops::phase_deg(measured)};
}

ChartMarks marks(const FigureSetting &setting, const loops::SpringDrive &drive) {
    const control::Coupling levels =
        control::coupling(drive.motor, drive.tuning, drive.period_s, drive.delay_periods);
    const auto corner_hz = [&drive](double resistance_Ohm) {
        return resistance_Ohm / drive.motor.inductance_H / (2.0 * std::numbers::pi);
    };
    ChartMarks marks;
    marks.add("heading", "Fig. 2: rendered stiffness K_θ of one motor, " + setting.device.name);
    marks.add("setting", tuning_text(setting));
    marks.add("unmodified_corner_hz", corner_hz(drive.motor.resistance_Ohm));
    marks.add("residual_corner_hz", corner_hz(drive.dR_Ohm()));
    marks.add("filter_corner_hz", drive.tuning.lambda_rad_per_s / (2.0 * std::numbers::pi));
    marks.add("half_servo_hz", 0.5 / drive.period_s);
    marks.add("K_DC", levels.K_DC_Nm_per_rad);
    marks.add("K_HF", levels.K_HF_Nm_per_rad);
    return marks;
}

/// Fig. 2: K_θ over frequency, by (12), sampled, measured, and of the unmodified motor.
Figure stiffness_figure(const FigureSetting &setting, const FigureProgress &progress) {
    constexpr std::size_t kMotor = 1; // of q₂, the first joint that moves the tip in its plane
    const loops::SpringDrive drive{setting.device.motor[kMotor], setting.tuning,
                                   setting.servo_period_s, 0};
    Figure figure;
    figure.numbers = Table::with_columns(
        "freq_hz,unmodified_motor,analytic,sampled,measured,unmodified_motor_phase_deg,"
        "analytic_phase_deg,sampled_phase_deg,measured_phase_deg",
        kFigureFormat);
    constexpr int kRows = kPointsPerDecade * kDecades;
    for (int i = 0; i <= kRows; ++i) {
        figure.numbers.rows.push_back(
            row(drive, std::pow(10.0, static_cast<double>(i) / kPointsPerDecade)));
        progress(static_cast<double>(i) / kRows);
    }
    figure.marks = marks(setting, drive);
    return figure;
}

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

/// Fig. 3: the tip's stiffness under both maps, by (21) and (27), and measured.
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
    add_headings(figure.marks, setting,
                 "Fig. 3: static tip stiffness, " + setting.device.name + " with its base locked");
    add_linkage(figure.marks, setting);
    add_scale(figure.marks, setting, stiffness);
    progress(1.0);
    return figure;
}

/// Fig. 5: the forces of both maps against a wall above the device.
Figure forces_figure(const FigureSetting &setting, const FigureProgress &progress) {
    constexpr double kDown_rad = -0.5 * std::numbers::pi; // a wall above the device
    const double penetration_m = std::min(harmless_m(setting, control::MotionMap::inverse),
                                          harmless_m(setting, control::MotionMap::transpose));
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
    add_headings(figure.marks, setting,
                 "Fig. 5: forces against a horizontal wall above, " + setting.device.name);
    figure.marks.add("penetration", penetration_text(penetration_m));
    figure.marks.add("longest_N", longest_N);
    return figure;
}

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
    add_headings(marks, setting, "Fig. 6: direction error of the force, " + setting.device.name);
    marks.add("inverse_penetration", depth_text(control::MotionMap::inverse));
    marks.add("transpose_penetration", depth_text(control::MotionMap::transpose));
    // The prediction as a curve, also between the surfaces.
    marks.add("K_xx", stiffness.inverse(0, 0));
    marks.add("K_xy", stiffness.inverse(0, 1));
    marks.add("K_yy", stiffness.inverse(1, 1));
    return marks;
}

/// Fig. 6: the direction error of both maps against surfaces in all directions.
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

constexpr std::array<double, 3> kFilters_rad_per_s{300.0, 1000.0, 3000.0};

loops::PlanarContact contact_in(const FigureSetting &setting) {
    loops::PlanarContact contact;
    contact.J = loops::planar_jacobian(setting.device.geometry, setting.q_rad);
    contact.alpha_rad2_per_m2 =
        loops::planar_stiffness(setting.device, setting.tuning, setting.q_rad).alpha_rad2_per_m2;
    contact.relative_stiffness = control::relative_stiffness(setting.device).tail<2>();
    for (std::size_t j = 0; j < 2; ++j) {
        contact.drive[j] = {setting.device.motor[j + 1], setting.tuning, setting.servo_period_s, 0};
    }
    return contact;
}

double error_deg(loops::PlanarContact contact, control::MotionMap map, double frequency_hz,
                 double lambda_rad_per_s) {
    for (loops::SpringDrive &drive : contact.drive) {
        drive.tuning.lambda_rad_per_s = lambda_rad_per_s;
    }
    const double omega = 2.0 * std::numbers::pi * frequency_hz;
    return kDegreesPerRadian *
           loops::worst_direction_error_rad(loops::tip_stiffness(contact, map, omega));
}

/// Fig. 7, beyond the paper: the direction error of both maps over frequency, computed.
Figure direction_over_frequency_figure(const FigureSetting &setting,
                                       const FigureProgress &progress) {
    constexpr int kRowsPerDecade = 30;
    constexpr int kRows = 3 * kRowsPerDecade; // 1 Hz to 1 kHz
    const loops::PlanarContact contact = contact_in(setting);
    Figure figure;
    figure.numbers = Table::with_columns("freq_hz,inverse_deg", kFigureFormat);
    for (const double lambda : kFilters_rad_per_s) {
        figure.numbers.columns.push_back(
            {"transpose_lambda_" + number_text(lambda, 4) + "_deg", kFigureFormat});
    }
    for (int i = 0; i <= kRows; ++i) {
        const double f_hz = std::pow(10.0, static_cast<double>(i) / kRowsPerDecade);
        std::vector<Cell> row{
            f_hz, error_deg(contact, control::MotionMap::inverse, f_hz, kFilters_rad_per_s[0])};
        for (const double lambda : kFilters_rad_per_s) {
            row.emplace_back(error_deg(contact, control::MotionMap::transpose, f_hz, lambda));
        }
        figure.numbers.rows.push_back(std::move(row));
        progress(static_cast<double>(i) / kRows);
    }
    figure.marks.add("heading", "Fig. 7: direction error over frequency, worst over the normals, " +
                                    setting.device.name);
    figure.marks.add("setting", angles_text(setting) + "; " + gains_text(setting));
    figure.marks.add("half_servo_hz", 0.5 / setting.servo_period_s);
    return figure;
}

constexpr std::array<FigureMaker, 5> kFigures{{
    {"fig2_stiffness", stiffness_figure},
    {"fig3_ellipses", ellipses_figure},
    {"fig5_forces", forces_figure},
    {"fig6_direction_error", direction_error_figure},
    {"fig7_direction_over_frequency", direction_over_frequency_figure},
}};

} // namespace

std::span<const FigureMaker> figure_makers() { return kFigures; }

} // namespace springdrive::app

// Figure 7, beyond the paper: high frequencies, which its section V discusses.
#include "app/figures/figure_text.h"
#include "engine/control/motion_control.h"
#include "engine/lab/loops/direction_spectrum.h"
#include "engine/lab/loops/stiffness_ellipse.h"

#include <array>
#include <cmath>
#include <numbers>
#include <string>

namespace springdrive::app {

namespace {

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

} // namespace

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

} // namespace springdrive::app

// Fig. 2 of the paper.
#include "app/figures/figure_text.h"
#include "engine/control/coupling.h"
#include "engine/lab/loops/stiffness_sweep.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace springdrive::app {

namespace {

constexpr int kPointsPerDecade = 20;
constexpr int kDecades = 4; ///< 1 Hz to 10 kHz: below R/L and above it

/// The highest frequency to be measured, relative to the servo rate; above one half there is
/// aliasing.
constexpr double kMaxMeasured = 0.45;

std::vector<Cell> row(const loops::SpringDrive &drive, double wanted_hz) {
    const bool measurable = wanted_hz * drive.period_s <= kMaxMeasured;
    const loops::SweepWindow window =
        measurable ? loops::sweep_window(wanted_hz, drive.period_s) : loops::SweepWindow{};
    const double frequency_hz = measurable ? window.frequency_hz(drive.period_s) : wanted_hz;
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

} // namespace

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

} // namespace springdrive::app

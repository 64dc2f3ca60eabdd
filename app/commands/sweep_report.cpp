#include "app/commands/sweep_report.h"

#include "app/commands/output_files.h"
#include "app/figures/gnuplot.h"
#include "app/host/asset_folder.h"
#include "base/degrees.h"
#include "base/print.h"
#include "engine/lab/loops/stiffness_sweep.h"

#include <fmt/core.h>

#include <cmath>

namespace springdrive::app {

namespace {

using commissioning::MotorSweep;
using commissioning::SweepOptions;
using commissioning::SweepPoint;
using commissioning::SweepReport;

std::string settings_text(const SweepOptions &options) {
    const control::Tuning &tuning = options.tuning;
    return fmt::format("dR {:.4g} Ω, K_P {:.4g} V/rad, K_D {:.4g} V·s/rad, λ {:.4g} rad/s, servo "
                       "{:.5g} Hz",
                       tuning.dR_Ohm, tuning.K_P_V_per_rad, tuning.K_D_Vs_per_rad,
                       tuning.lambda_rad_per_s, options.servo_hz);
}

Table table_of(const MotorSweep &sweep) {
    Table table = Table::with_columns(
        "freq_hz:.4g,measured\n|K_θ|:.5f,phase,sampled\n|K_θ|:.5f,phase,(12)\n|K_θ|:.5f,phase,"
        "measured to sampled\n%,deg,+-%,:",
        ".2f");
    for (const SweepPoint &point : sweep.points) {
        table.rows.push_back(
            {point.frequency_hz, std::abs(point.measured_Nm_per_rad),
             loops::phase_deg(point.measured_Nm_per_rad), std::abs(point.sampled_Nm_per_rad),
             loops::phase_deg(point.sampled_Nm_per_rad), std::abs(point.analytic_Nm_per_rad),
             loops::phase_deg(point.analytic_Nm_per_rad), 100.0 * point.magnitude_error(),
             kDegreesPerRadian * point.phase_error_rad(), 100.0 * point.deviation,
             point.deviation <= commissioning::kUncertain ? "" : "?"});
    }
    return table;
}

} // namespace

void write_sweep_table(std::ostream &out, const device::DeviceDescription &device,
                       const SweepOptions &options, const SweepReport &report) {
    print(out, "{}: {}\n", device.name, settings_text(options));
    for (const MotorSweep &sweep : report.motors) {
        const device::MotorParameters &file = device.motor[sweep.motor];
        print(out,
              "\nmotor {}: dR {:.4f} Ω, L {:.3f} mH (file {:.3f}), k_T {:.2f} mN·m/A (file "
              "{:.2f}), d {:.3f} periods\n",
              sweep.motor + 1, sweep.winding.dR_Ohm, 1e3 * sweep.winding.inductance_H,
              1e3 * file.inductance_H, 1e3 * sweep.winding.torque_constant_Nm_per_A,
              1e3 * file.torque_constant_Nm_per_A, sweep.points.front().delay_periods);
        write_text(out, table_of(sweep));
    }
    if (report.is_complete && !report.is_certain()) {
        print(out,
              "\n?  known to more than {:.0f} % only: hardly any force flows there; hold the "
              "tip more firmly, or allow more force or motion\n",
              100.0 * commissioning::kUncertain);
    }
}

Table sweep_table(const SweepReport &report) {
    Table table = Table::with_columns(
        "motor,freq_hz,measured_mag,measured_phase_deg,deviation_percent,sampled_mag,"
        "sampled_phase_deg,analytic_mag,analytic_phase_deg,magnitude_error_percent,"
        "phase_error_deg,delay_periods,excitation_V",
        ".9g");
    for (const MotorSweep &sweep : report.motors) {
        for (const SweepPoint &point : sweep.points) {
            table.rows.push_back(
                {sweep.motor + 1, point.frequency_hz, std::abs(point.measured_Nm_per_rad),
                 loops::phase_deg(point.measured_Nm_per_rad), 100.0 * point.deviation,
                 std::abs(point.sampled_Nm_per_rad), loops::phase_deg(point.sampled_Nm_per_rad),
                 std::abs(point.analytic_Nm_per_rad), loops::phase_deg(point.analytic_Nm_per_rad),
                 100.0 * point.magnitude_error(), kDegreesPerRadian * point.phase_error_rad(),
                 point.delay_periods, point.excitation_V});
        }
    }
    return table;
}

std::filesystem::path numbers_of_sweep(std::filesystem::path svg) {
    return svg.replace_extension(".csv");
}

void draw_sweep(const std::filesystem::path &svg, const std::string &device_text,
                const SweepOptions &options, const SweepReport &report, Existing existing) {
    const std::filesystem::path csv = numbers_of_sweep(svg);
    write_output(
        csv.string(), [&](std::ostream &out) { write_csv(out, sweep_table(report)); }, existing);
    ChartMarks marks;
    marks.add("heading", "Rendered stiffness K_θ by sine sweep, " + device_text);
    marks.add("setting",
              settings_text(options) +
                  fmt::format(", d {:.3f}", report.motors.front().points.front().delay_periods));
    const std::filesystem::path folder =
        svg.parent_path().empty() ? std::filesystem::path(".") : svg.parent_path();
    draw({asset_folder() / "figures" / "device_sweep.gnuplot", marks.assignments(), folder,
          csv.filename().string(), svg.filename().string()},
         existing);
}

} // namespace springdrive::app

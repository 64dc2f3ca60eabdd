#include "app/commands/stiffness_report.h"

#include "base/print.h"
#include "engine/control/coupling.h"
#include "engine/lab/loops/stability_case.h"

#include <numbers>

namespace springdrive::app {

namespace {

double hz(double rad_per_s) { return rad_per_s / (2.0 * std::numbers::pi); }

/// Of the three joints in rigid contact, the least stable one.
loops::WorstMember worst_joint(const device::DeviceDescription &device,
                               const loops::SpringDrive &drive) {
    loops::StabilityCase each = loops::motors_alone(device, drive.tuning);
    each.tuning.eta = 0.0;
    each.period_s = drive.period_s;
    each.delay_periods = drive.delay_periods;
    return loops::worst_member(each);
}

void write_head(std::ostream &out, const device::DeviceDescription &device,
                const loops::SpringDrive &drive) {
    const device::MotorParameters &motor = drive.motor;
    const control::Tuning &tuning = drive.tuning;
    const control::Coupling levels =
        control::coupling(motor, tuning, drive.period_s, drive.delay_periods);
    print(out, "{}, first motor: R {:.4g} Ω, L {:.4g} mH, k_T {:.4g} mN·m/A\n", device.name,
          motor.resistance_Ohm, 1e3 * motor.inductance_H, 1e3 * motor.torque_constant_Nm_per_A);
    print(out, "dR {:.4g} Ω, K_P {:.4g} V/rad, K_D {:.4g} V·s/rad, λ {:.4g} rad/s, ",
          drive.dR_Ohm(), tuning.K_P_V_per_rad, tuning.K_D_Vs_per_rad, tuning.lambda_rad_per_s);
    print(out, "servo {:.5g} Hz, delay {:g}\n\n", 1.0 / drive.period_s, drive.delay_periods);
    print(out, "K_DC = k_T K_P/dR (13)  {:.4g} N·m/rad\n", levels.K_DC_Nm_per_rad);
    print(out, "K_HF = k_T²/L     (14)  {:.4g} N·m/rad\n", levels.K_HF_Nm_per_rad);
    print(out, "corners                 dR/L {:.4g} Hz, λ {:.4g} Hz, R/L {:.4g} Hz\n",
          hz(drive.dR_Ohm() / motor.inductance_H), hz(tuning.lambda_rad_per_s),
          hz(motor.resistance_Ohm / motor.inductance_H));
    const loops::WorstMember worst = worst_joint(device, drive);
    print(out, "rigid contact, no hand  {}: largest eigenvalue {:.6f}\n\n",
          worst.is_stable() ? "stable" : "UNSTABLE", worst.eigenvalue);
}

} // namespace

void write_stiffness_report(std::ostream &out, const device::DeviceDescription &device,
                            const loops::SpringDrive &drive,
                            const std::vector<loops::StiffnessPoint> &points) {
    write_head(out, device, drive);
    const Table table{Table::with_columns("frequency\nHz:.5g,(12)\nN·m/rad:.5f,deg:.2f,"
                                          "sampled\nN·m/rad:.5f,deg:.2f,measured\nN·m/rad:.5f,"
                                          "deg:.2f")
                          .columns,
                      loops::stiffness_table(points).rows};
    write_text(out, table);
}

} // namespace springdrive::app

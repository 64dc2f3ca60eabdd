// What a tuning renders, the best one, and the same of a current drive.
#include "app/commands/command.h"

#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "base/input_error.h"
#include "base/print.h"
#include "device/core/device_description.h"
#include "device/core/device_file.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/lab/limits/auto_tune.h"
#include "engine/lab/limits/drive_comparison.h"
#include "engine/lab/limits/thermal_hold.h"
#include "engine/lab/loops/rendered_stiffness.h"
#include "engine/lab/loops/stability_case.h"
#include "engine/servo/servo.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <numbers>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

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

/// @param drive  the device's first motor and its tuning, of which `points` is the sweep
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

/// One period is a million ticks of the fastest servo.
constexpr double kMin_hz = 0.01;
constexpr int kMaxPoints = 10000;

struct TypedStiffness {
    std::filesystem::path device_file;
    TuningOptions tuning;
    std::vector<double> motor; ///< R, L, k_T; empty: the device file's
    double servo_hz = 1000.0;
    double delay_periods = 0.0;
    double min_hz = 1.0;
    std::optional<double> max_hz; ///< a quarter of the servo rate
    int points = 25;
    std::vector<Option> of_a_sweep; ///< the options above, which a hold cannot use
    std::optional<double> hold_N;
    std::optional<double> seconds;
    std::string csv; ///< empty: a table for people
    Existing existing = Existing::keep;
};

/// The device with the given motors.
device::DeviceDescription device_of(const TypedStiffness &typed) {
    device::DeviceDescription device = device::read_device_file(typed.device_file);
    if (typed.motor.empty()) {
        return device;
    }
    // The ranges of device files.
    check_range("--motor: R [Ohm]", typed.motor[0], 0.01, 1000.0);
    check_range("--motor: L [H]", typed.motor[1], 1e-6, 0.1);
    check_range("--motor: kT [N·m/A]", typed.motor[2], 1e-4, 10.0);
    for (device::MotorParameters &motor : device.motor) {
        motor.resistance_Ohm = typed.motor[0];
        motor.inductance_H = typed.motor[1];
        motor.torque_constant_Nm_per_A = typed.motor[2];
    }
    return device;
}

control::Tuning tuning_for(const device::DeviceDescription &device, const TypedStiffness &typed) {
    const control::Tuning tuning = typed.tuning.tuning();
    check_dR(device, tuning);
    static_cast<void>(cold_dR_Ohm(device, tuning)); // the bench itself uses the requested dR
    return tuning;
}

loops::SweepRange range_of(const TypedStiffness &typed) {
    const double half_rate_hz = 0.5 * typed.servo_hz;
    const double max_hz = typed.max_hz.value_or(0.5 * half_rate_hz);
    check_range("--freq-from", typed.min_hz, kMin_hz, half_rate_hz);
    check_range("--freq-to", max_hz, kMin_hz, half_rate_hz);
    check_range("--points", typed.points, 2, kMaxPoints);
    if (!(typed.min_hz < max_hz)) {
        throw InputError("--freq-from must be below --freq-to");
    }
    return {typed.min_hz, max_hz, typed.points};
}

void sweep(const TypedStiffness &typed) {
    const device::DeviceDescription device = device_of(typed);
    loops::SpringDrive drive;
    drive.motor = device.motor[0];
    drive.tuning = tuning_for(device, typed);
    drive.period_s = servo::servo_period_s(typed.servo_hz);
    check_delay(typed.delay_periods);
    drive.delay_periods = typed.delay_periods;
    const std::vector<loops::StiffnessPoint> points =
        loops::stiffness_sweep(drive, range_of(typed));
    write_report(
        [&](std::ostream &out) { write_stiffness_report(out, device, drive, points); },
        {{typed.csv, [&](std::ostream &out) { write_csv(out, loops::stiffness_table(points)); }}},
        typed.existing);
}

void hold(const TypedStiffness &typed) {
    for (const Option &option : typed.of_a_sweep) {
        if (option.is_given()) {
            throw InputError(option.name() + ": belongs to a sweep; omit it with --hold");
        }
    }
    const device::DeviceDescription device = device_of(typed);
    limits::ThermalHoldOptions options;
    options.tuning = tuning_for(device, typed);
    options.force_N = *typed.hold_N;
    options.seconds = typed.seconds.value_or(600.0);
    const std::vector<limits::ThermalRow> rows = limits::thermal_hold(device, options);
    write_report(
        [&](std::ostream &out) { limits::write_thermal_table(out, rows); },
        {{typed.csv, [&](std::ostream &out) { write_csv(out, limits::thermal_table(rows)); }}},
        typed.existing);
}

void run(const TypedStiffness &typed) {
    check_outputs({{typed.device_file, typed.tuning.file}, {}, {typed.csv}}, typed.existing);
    if (typed.hold_N) {
        hold(typed);
    } else {
        sweep(typed);
    }
}

void add_sweep_options(Command &stiffness, TypedStiffness &typed) {
    typed.of_a_sweep = {
        add_servo_hz_option(stiffness, typed.servo_hz),
        add_delay_option(stiffness, typed.delay_periods),
        stiffness.add_option("--freq-from", typed.min_hz, "lowest frequency [1]").type_name("HZ"),
        stiffness
            .add_option("--freq-to", typed.max_hz,
                        "highest frequency, up to half the servo rate [a quarter]")
            .type_name("HZ"),
        stiffness
            .add_option("--points", typed.points,
                        "number of frequencies, logarithmically spaced [25]")
            .type_name("N")};
}

void add_hold_options(Command &stiffness, TypedStiffness &typed) {
    Option hold = stiffness
                      .add_option("--hold", typed.hold_N,
                                  "instead of a sweep: hold a contact with this force, and "
                                  "show how the motors heat up, soften and cool")
                      .type_name("N");
    stiffness
        .add_option("--seconds", typed.seconds,
                    "duration of the hold, and of cooling after it [600]")
        .type_name("S")
        .needs(hold);
}

} // namespace

void add_stiffness_command(Command &app) {
    Command stiffness = app.add_subcommand(
        "stiffness", "the coupling K_θ over frequency: (12), sampled and measured");
    const auto typed = std::make_shared<TypedStiffness>();
    add_device_file_option(stiffness, typed->device_file);
    stiffness
        .add_option("--motor", typed->motor,
                    "resistance, inductance and torque constant in place of the device file's")
        .type_name("R,L,kT")
        .delimiter(',')
        .expected(3);
    typed->tuning.add_to(stiffness, TuningScope::coupling);
    add_sweep_options(stiffness, *typed);
    add_hold_options(stiffness, *typed);
    add_output_option(stiffness, "--csv", typed->csv, "CSV");
    add_force_option(stiffness, typed->existing);
    stiffness.footer("Phases are those of -τ/θ: a spring has 0°, a damper +90°.");
    stiffness.callback([typed] { run(*typed); });
}

void write_tuned(std::ostream &out, const limits::AutoTuned &found) {
    const control::TuningMargins &margins = found.margins;
    print(out, "K_P {:.4g} V/rad, K_D {:.4g} V·s/rad, λ {:.4g} rad/s: K_DC {:.4g} N·m/rad\n",
          found.tuning.K_P_V_per_rad, found.tuning.K_D_Vs_per_rad, found.tuning.lambda_rad_per_s,
          margins.K_DC_Nm_per_rad);
    print(out, "stable in {} loops: every hand, configuration and η\n", found.loops);
    print(out, "coupling {}\n", found.coupling);
    print(out, "margins: K_P and K_D × {:.3g} (then unstable with {} at η {:.2g})", margins.gain,
          loops::hand_text(margins.worst_hand), margins.worst_eta);
    print(out, ", {} more whole periods of delay, dR down to {:.3g} Ω\n",
          margins.more_delay_periods, margins.min_dR_Ohm);
    print(out, "with compliance in cables, links or both, here: K_P and K_D × {:.3g}{}\n",
          found.gain_with_structure, found.gain_with_structure < 1.0 ? ", UNSTABLE" : "");
    if (found.tuning.K_P_V_per_rad >= limits::AutoTuneRequest{}.max_K_P_V_per_rad) {
        out << "K_P is at the end of its range: larger values would be stable\n";
    }
    if (found.taken_back > 0.0) {
        print(out,
              "K_P is {:.0f} % below the predicted limit: encoder counts sustained a "
              "vibration\n",
              100.0 * found.taken_back);
    }
}

namespace {

struct TypedTune {
    std::filesystem::path device_file;
    double dR_Ohm = control::Tuning{}.dR_Ohm;
    double servo_hz = 1000.0;
    double delay_periods = 0.0;
    double margin = limits::AutoTuneRequest{}.margin;
    bool is_stable_only = false;
    std::string kinematics{control::name_of(control::MotionMap::transpose)};
    std::string out; ///< empty: standard output, after the report
    Existing existing = Existing::keep;
};

limits::AutoTuneRequest request_of(const TypedTune &typed) {
    limits::AutoTuneRequest request;
    loops::StabilityCase &which = request.which;
    which.device = device::read_device_file(typed.device_file);
    which.tuning.dR_Ohm = typed.dR_Ohm;
    which.tuning.map = *control::motion_map_named(typed.kinematics);
    if (const std::string wrong = control::validate(which.tuning); !wrong.empty()) {
        throw InputError("--dR: " + wrong);
    }
    check_dR(which.device, which.tuning);
    which.period_s = servo::servo_period_s(typed.servo_hz);
    check_delay(typed.delay_periods);
    which.delay_periods = typed.delay_periods;
    check_range("--margin", typed.margin, 1.0, 10.0);
    request.margin = typed.margin;
    request.is_passive = !typed.is_stable_only;
    return request;
}

std::string description_of(const TypedTune &typed, const limits::AutoTuned &found) {
    return fmt::format("the stiffest {}for {:.4g} Hz and a delay of {:.4g} with dR {:.4g} Ω and a "
                       "margin of {:.4g}: K_DC {:.4g} N·m/rad at the motor",
                       typed.is_stable_only ? "" : "passive one ", typed.servo_hz,
                       typed.delay_periods, typed.dR_Ohm, typed.margin,
                       found.margins.K_DC_Nm_per_rad);
}

void run(const TypedTune &typed) {
    const limits::AutoTuneRequest request = request_of(typed);
    check_outputs({{typed.device_file}, {}, {typed.out}}, typed.existing);
    limits::AutoTuned found;
    {
        ProgressLine line;
        found = limits::auto_tune(request, [&line](double share) {
            line.show("tuning", share);
            return true;
        });
    }
    write_tuned(typed.out.empty() ? std::cerr : std::cout, found);
    write_output(
        typed.out.empty() ? "-" : typed.out,
        [&](std::ostream &out) {
            control::write_tuning_file(out,
                                       {found.tuning, description_of(typed, found), found.margins});
        },
        typed.existing);
}

} // namespace

void add_tune_command(Command &app) {
    Command tune = app.add_subcommand(
        "tune", "the stiffest tuning that is passive and stable, as a tuning file");
    const auto typed = std::make_shared<TypedTune>();
    add_device_file_option(tune, typed->device_file);
    tune.add_option("--dR", typed->dR_Ohm, "residual resistance (7), fixed in the search [0.5]")
        .type_name("Ω");
    add_servo_hz_option(tune, typed->servo_hz);
    add_delay_option(tune, typed->delay_periods);
    tune.add_option("--margin", typed->margin,
                    "factor by which K_P and K_D may still grow, 1 to 10 [1.3]")
        .type_name("FACTOR");
    tune.add_flag("--stable-only", typed->is_stable_only,
                  "stiffer: stable with the hands tried, but not passive");
    add_motion_map_option(tune, "--kinematics", typed->kinematics);
    tune.add_option("--out", typed->out, "the file to write [standard output]")
        .type_name("FILE.toml");
    add_force_option(tune, typed->existing);
    tune.footer("Try it:  springdrive tune --out mine.toml, then springdrive demo --tuning-file "
                "mine.toml");
    tune.callback([typed] { run(*typed); });
}

namespace {

struct TypedBaseline {
    std::filesystem::path device_file;
    std::optional<double> servo_hz;
    std::optional<double> delay_periods;
    std::optional<double> dR_Ohm;
    double margin = limits::AutoTuneRequest{}.margin;
    std::string csv; ///< empty: a table for people
    Existing existing = Existing::keep;
};

/// The default settings, or those of them with the given values; with all three given, that one.
std::vector<limits::ServoSetting> settings_of(const TypedBaseline &typed,
                                              const device::DeviceDescription &device) {
    std::vector<limits::ServoSetting> settings = limits::usual_settings();
    for (limits::ServoSetting &setting : settings) {
        setting.servo_hz = typed.servo_hz.value_or(setting.servo_hz);
        setting.delay_periods = typed.delay_periods.value_or(setting.delay_periods);
        setting.dR_Ohm = typed.dR_Ohm.value_or(setting.dR_Ohm);
        static_cast<void>(servo::servo_period_s(setting.servo_hz)); // rejects values out of range
        check_delay(setting.delay_periods);
        control::Tuning tuning;
        tuning.dR_Ohm = setting.dR_Ohm;
        check_dR(device, tuning);
    }
    std::vector<limits::ServoSetting> once;
    for (const limits::ServoSetting &setting : settings) {
        if (std::find(once.begin(), once.end(), setting) == once.end()) {
            once.push_back(setting);
        }
    }
    return once;
}

void run(const TypedBaseline &typed) {
    loops::StabilityCase which;
    which.device = device::read_device_file(typed.device_file);
    check_range("--margin", typed.margin, 1.0, 10.0);
    check_outputs({{typed.device_file}, {}, {typed.csv}}, typed.existing);
    const std::vector<limits::ServoSetting> settings = settings_of(typed, which.device);
    std::vector<limits::DriveComparison> all;
    {
        ProgressLine line;
        all = limits::compare_drives(which, typed.margin, settings, [&line](double share) {
            line.show("tuning both drives", share);
        });
    }
    write_report(
        [&](std::ostream &out) { limits::write_comparison_table(out, all); },
        {{typed.csv, [&](std::ostream &out) { write_csv(out, limits::comparison_table(all)); }}},
        typed.existing);
}

} // namespace

void add_baseline_command(Command &app) {
    Command baseline = app.add_subcommand(
        "baseline", "spring drive against current drive, each at its stable optimum");
    const auto typed = std::make_shared<TypedBaseline>();
    add_device_file_option(baseline, typed->device_file);
    baseline.add_option("--servo-hz", typed->servo_hz, "one rate [250, 1000, 4000 and 10000]")
        .type_name("HZ");
    baseline
        .add_option("--delay", typed->delay_periods,
                    "one delay in periods, a real number 0 to 8 [0 and 1]")
        .type_name("D");
    baseline.add_option("--dR", typed->dR_Ohm, "one dR of the spring drive [0.2 and 0.5]")
        .type_name("Ω");
    baseline
        .add_option("--margin", typed->margin,
                    "factor by which all gains may still grow, 1 to 10 [1.3]")
        .type_name("FACTOR");
    add_output_option(baseline, "--csv", typed->csv, "CSV");
    add_force_option(baseline, typed->existing);
    baseline.footer(
        fmt::format("Stiffness, rate-hardness (Lawrence et al. 2000) and mass are those "
                    "along the vertical at ({:g}°).",
                    fmt::join(device::kDefaultPose_deg, "°, ")));
    baseline.callback([typed] { run(*typed); });
}

} // namespace springdrive::app

#include "app/commands/commands.h"

#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "app/commands/progress_line.h"
#include "device/core/device_file.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/limits/drive_comparison.h"
#include "engine/servo/servo.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

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

#include "app/commands/commands.h"

#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "app/commands/progress_line.h"
#include "base/input_error.h"
#include "base/print.h"
#include "device/core/device_file.h"
#include "engine/lab/limits/auto_tune.h"
#include "engine/servo/servo.h"

#include <fmt/core.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <ostream>
#include <string>

namespace springdrive::app {

void write_tuned(std::ostream &out, const limits::AutoTuned &found) {
    const control::TuningMargins &margins = found.margins;
    print(out, "K_P {:.4g} V/rad, K_D {:.4g} V·s/rad, λ {:.4g} rad/s: K_DC {:.4g} N·m/rad\n",
          found.tuning.K_P_V_per_rad, found.tuning.K_D_Vs_per_rad, found.tuning.lambda_rad_per_s,
          margins.K_DC_Nm_per_rad);
    print(out, "stable in {} loops: every hand, configuration and η\n", found.loops);
    print(out, "margins: K_P and K_D × {:.3g} (then unstable with {} at η {:.2g})", margins.gain,
          loops::hand_text(margins.worst_hand), margins.worst_eta);
    print(out, ", {} more whole periods of delay, dR down to {:.3g} Ω\n",
          margins.more_delay_periods, margins.min_dR_Ohm);
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
    return request;
}

std::string description_of(const TypedTune &typed, const limits::AutoTuned &found) {
    return fmt::format("the stiffest for {:.4g} Hz and a delay of {:.4g} with dR {:.4g} Ω and a "
                       "margin of {:.4g}: K_DC {:.4g} N·m/rad at the motor",
                       typed.servo_hz, typed.delay_periods, typed.dR_Ohm, typed.margin,
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
        "tune", "the stiffest tuning that is stable with every hand, as a tuning file");
    const auto typed = std::make_shared<TypedTune>();
    add_device_file_option(tune, typed->device_file);
    tune.add_option("--dR", typed->dR_Ohm, "residual resistance (7), fixed in the search [0.5]")
        .type_name("Ω");
    add_servo_hz_option(tune, typed->servo_hz);
    add_delay_option(tune, typed->delay_periods);
    tune.add_option("--margin", typed->margin,
                    "factor by which K_P and K_D may still grow, 1 to 10 [1.3]")
        .type_name("FACTOR");
    add_motion_map_option(tune, "--kinematics", typed->kinematics);
    tune.add_option("--out", typed->out, "the file to write [standard output]")
        .type_name("FILE.toml");
    add_force_option(tune, typed->existing);
    tune.footer("Try it:  springdrive tune --out mine.toml, then springdrive demo --tuning-file "
                "mine.toml");
    tune.callback([typed] { run(*typed); });
}

} // namespace springdrive::app

#include "app/commands/command.h"

#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "app/figures/figure.h"
#include "app/figures/gnuplot.h"
#include "base/input_error.h"
#include "device/core/device_file.h"
#include "engine/lab/limits/locked_device.h"
#include "engine/lab/loops/link_plane.h"
#include "engine/lab/rig/scenario/scenarios.h"

#include <cstdint>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

namespace springdrive::app {

namespace {

struct TypedFigures {
    std::filesystem::path out;
    std::filesystem::path device_file;
    std::filesystem::path tuning_file; ///< empty: the default tuning
    std::vector<double> q_deg = default_joint_angles_deg();
    std::uint64_t device_seed = FigureSetting{}.device_seed;
    Existing existing = Existing::keep;
};

/// If friction can hold half of the force of the transpose map, it affects directions as well.
void warn_about_friction(const FigureSetting &setting) {
    const double rendered_N =
        loops::planar_stiffness(setting.device, setting.tuning, setting.q_rad).transpose(0, 0) *
        limits::harmless_penetration_m(setting.device, setting.tuning, setting.q_rad,
                                       control::MotionMap::transpose);
    const double friction_N = limits::breakaway_force_N(setting.device, setting.q_rad);
    if (2.0 * friction_N > rendered_N) {
        std::cerr << "springdrive: remark: friction can hold " << friction_N
                  << " N at the tip, which is not small compared with the " << rendered_N
                  << " N of the transpose map: it affects the directions in figures 5 and 6\n";
    }
}

FigureSetting setting_of(const TypedFigures &typed) {
    FigureSetting setting;
    setting.device = device::read_device_file(typed.device_file);
    setting.tuning = tuning_of(typed.tuning_file);
    setting.q_rad = joint_angles_rad(typed.q_deg);
    setting.device_seed = typed.device_seed;
    rig::check_configuration(setting.device, setting.q_rad);
    check_dR(setting.device, setting.tuning);
    setting.tuning.dR_Ohm = cold_dR_Ohm(setting.device, setting.tuning);
    warn_about_friction(setting);
    return setting;
}

/// All numbers first, so that they exist even if nothing can be drawn.
void make_figures(const TypedFigures &typed) {
    const FigureSetting setting = setting_of(typed);
    make_output_folder(typed.out);
    RunFiles files{{typed.device_file, typed.tuning_file}, {}, {}};
    for (const FigureMaker &maker : figure_makers()) {
        add_chart_files(files, typed.out, maker.name);
    }
    check_outputs(files, typed.existing);
    ProgressLine line;
    std::vector<Chart> charts;
    for (const FigureMaker &maker : figure_makers()) {
        const std::string name(maker.name);
        const Figure figure = maker.make(setting, [&](double share) { line.show(name, share); });
        write_output((typed.out / (name + ".csv")).string(),
                     [&](std::ostream &out) { write_csv(out, figure.numbers); }, typed.existing);
        charts.push_back(chart_of(name, figure.marks, typed.out, name + ".csv", name + ".svg"));
    }
    for (const Chart &chart : charts) {
        line.show(chart.svg, 1.0);
        draw(chart, typed.existing);
    }
}

} // namespace

void add_figures_command(Command &app) {
    Command figures = app.add_subcommand(
        "figures", "figures 2, 3, 5 and 6 of the paper, measured and predicted, and the direction "
                   "error over frequency, computed, as SVG and CSV");
    const auto typed = std::make_shared<TypedFigures>();
    figures.add_option("--out", typed->out, "the folder to write to; created if missing")
        .type_name("DIR")
        .required();
    add_force_option(figures, typed->existing);
    add_device_file_option(figures, typed->device_file);
    add_tuning_file_option(figures, typed->tuning_file);
    add_joint_angles_option(figures, typed->q_deg);
    figures
        .add_option("--device-seed", typed->device_seed,
                    "which simulated device of its kind is measured in figures 3, 5 and 6")
        .type_name("N")
        .in_range(1, 1'000'000'000)
        .capture_default_str();
    figures.callback([typed] { make_figures(*typed); });
}

} // namespace springdrive::app

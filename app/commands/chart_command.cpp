#include "app/commands/command.h"

#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "app/figures/gnuplot.h"
#include "app/figures/speed_accuracy_marks.h"
#include "base/timing.h"
#include "device/core/device_file.h"
#include "engine/lab/charts/charts.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

namespace springdrive::app {

namespace {

constexpr int kMaxRepeats = 100;

struct TypedChart {
    std::filesystem::path out;
    std::filesystem::path device_file;
    std::filesystem::path tuning_file; ///< empty: the default tuning
    std::vector<std::string> only;     ///< empty: all charts
    int repeats = charts::ChartSetting{}.repeats;
    Existing existing = Existing::keep;
};

charts::ChartSetting setting_of(const TypedChart &typed) {
    charts::ChartSetting setting;
    setting.device = device::read_device_file(typed.device_file);
    setting.tuning = tuning_of(typed.tuning_file);
    check_dR(setting.device, setting.tuning);
    check_range("--repeats", typed.repeats, 1, kMaxRepeats);
    setting.repeats = typed.repeats;
    return setting;
}

bool is_asked_for(const TypedChart &typed, std::string_view name) {
    return typed.only.empty() || std::ranges::find(typed.only, name) != typed.only.end();
}

std::string footnote(const charts::ChartSetting &setting, const std::string &machine) {
    return machine + "; points: minimum of " + std::to_string(setting.repeats) +
           " repetitions; bars: to the maximum; large mark: the first setting";
}

/// All numbers first, so that they exist even if nothing can be drawn.
void make_charts(const TypedChart &typed) {
    const charts::ChartSetting setting = setting_of(typed);
    make_output_folder(typed.out);
    RunFiles files{{typed.device_file, typed.tuning_file}, {}, {}};
    for (const charts::ChartMaker &maker : charts::kCharts) {
        if (is_asked_for(typed, maker.name)) {
            add_chart_files(files, typed.out, maker.name);
        }
    }
    check_outputs(files, typed.existing);
    const std::string machine = machine_name();
    ProgressLine line;
    std::vector<Chart> pictures;
    for (const charts::ChartMaker &maker : charts::kCharts) {
        if (!is_asked_for(typed, maker.name)) {
            continue;
        }
        const charts::SpeedAccuracyChart chart =
            maker.make(setting, [&](double share) { line.show(maker.name, share); });
        write_output(
            (typed.out / (chart.name + ".csv")).string(),
            [&](std::ostream &out) { write_csv(out, charts::chart_table(chart, machine)); },
            typed.existing);
        pictures.push_back(chart_of("speed_accuracy",
                                    speed_accuracy_marks(chart, footnote(setting, machine)),
                                    typed.out, chart.name + ".csv", chart.name + ".svg"));
    }
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        line.show("pictures", static_cast<double>(i) / static_cast<double>(pictures.size()));
        draw(pictures[i], typed.existing);
    }
}

std::vector<std::string> chart_names() {
    std::vector<std::string> names;
    names.reserve(charts::kCharts.size());
    for (const charts::ChartMaker &maker : charts::kCharts) {
        names.emplace_back(maker.name);
    }
    return names;
}

} // namespace

void add_chart_command(Command &app) {
    Command chart = app.add_subcommand(
        "chart", "speed and accuracy of integrators, plant models, motion control, proxies "
                 "and servo rates: each method's cost and error, as SVG and CSV");
    const auto typed = std::make_shared<TypedChart>();
    chart.add_option("--out", typed->out, "the folder to write to; created if missing")
        .type_name("DIR")
        .required();
    chart.add_option("--only", typed->only, "only these charts, separated by commas")
        .type_name("NAME,...")
        .delimiter(',')
        .one_of(chart_names());
    chart
        .add_option("--repeats", typed->repeats,
                    "repetitions of each timing, from 1 to " + std::to_string(kMaxRepeats) + " [" +
                        std::to_string(typed->repeats) + "]")
        .type_name("N");
    add_force_option(chart, typed->existing);
    add_device_file_option(chart, typed->device_file);
    add_tuning_file_option(chart, typed->tuning_file);
    chart.callback([typed] { make_charts(*typed); });
}

} // namespace springdrive::app

#include "app/commands/stability_map_chart.h"

#include "app/commands/output_files.h"
#include "app/figures/gnuplot.h"
#include "app/host/asset_folder.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace springdrive::app {

namespace {

/// For gnuplot, in which an underscore begins an index.
std::string symbol_of(const loops::StabilityParameter &parameter) {
    const std::string symbol(parameter.symbol);
    const std::size_t line = symbol.find('_');
    return line == std::string::npos
               ? symbol
               : symbol.substr(0, line) + "_{" + symbol.substr(line + 1) + "}";
}

std::string axis_label(const loops::StabilityParameter &parameter) {
    return symbol_of(parameter) +
           (parameter.unit == "–" ? "" : "  (" + std::string(parameter.unit) + ")");
}

/// Half a cell, by which a picture extends beyond the outermost values.
void add_axis(ChartMarks &marks, const std::string &name, const limits::MapAxis &axis) {
    const std::vector<double> values = axis.values();
    const bool by_ratio = axis.is_logarithmic();
    const double first = by_ratio ? std::log10(values.front()) : values.front();
    const double last = by_ratio ? std::log10(values.back()) : values.back();
    const double half = 0.5 * (last - first) / static_cast<double>(values.size() - 1);
    marks.add(name + "_label", axis_label(*axis.parameter));
    marks.add(name + "_by_ratio", by_ratio ? 1.0 : 0.0);
    marks.add(name + "_first", first - half);
    marks.add(name + "_last", last + half);
}

/// The legend if a line is missing because all cells are on one side of it.
std::string instead_of_a_line(const std::string &line, std::size_t stable, std::size_t all) {
    return stable == all ? line + ": stable everywhere"
           : stable == 0 ? line + ": stable nowhere"
                         : "";
}

/// A header and a row for each cell.
std::string csv_of(const limits::MapAxis &x, const limits::MapAxis &y,
                   const std::vector<limits::MapCell> &cells) {
    std::string csv = fmt::format("{},{},largest_eigenvalue,stable_simulated,remaining_m_per_s\n",
                                  x.parameter->name, y.parameter->name);
    const std::size_t columns = x.values().size();
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const limits::MapCell &cell = cells[i];
        fmt::format_to(std::back_inserter(csv), "{:.9g},{:.9g},{:.9g},{:d},{:.9g}\n", cell.x,
                       cell.y, cell.eigenvalue, cell.stable, cell.remaining_m_per_s);
        if ((i + 1) % columns == 0) {
            csv += '\n'; // gnuplot's separator between rows of a grid
        }
    }
    return csv;
}

} // namespace

std::filesystem::path numbers_of_map(std::filesystem::path svg) {
    return svg.replace_extension(".csv");
}

void draw_stability_map(const std::filesystem::path &svg, const MapSetting &setting,
                        const limits::MapAxis &x, const limits::MapAxis &y,
                        const std::vector<limits::MapCell> &cells, Existing existing) {
    const std::filesystem::path csv = numbers_of_map(svg);
    write_output(
        csv.string(), [&](std::ostream &out) { out << csv_of(x, y, cells); }, existing);
    ChartMarks marks;
    marks.add("heading", "Stability over " + std::string(x.parameter->symbol) + " and " +
                             std::string(y.parameter->symbol));
    marks.add("setting", setting.values);
    marks.add("loop", setting.loop);
    add_axis(marks, "x", x);
    add_axis(marks, "y", y);
    const auto predicted = static_cast<std::size_t>(std::ranges::count_if(
        cells, [](const limits::MapCell &cell) { return cell.eigenvalue < 1.0; }));
    const auto by_trial =
        static_cast<std::size_t>(std::ranges::count_if(cells, &limits::MapCell::stable));
    marks.add("no_predicted_line", instead_of_a_line("predicted", predicted, cells.size()));
    marks.add("no_trial_line", instead_of_a_line("by trial", by_trial, cells.size()));
    const std::filesystem::path folder =
        svg.parent_path().empty() ? std::filesystem::path(".") : svg.parent_path();
    draw({asset_folder() / "figures" / "stability_map.gnuplot", marks.assignments(), folder,
          csv.filename().string(), svg.filename().string()},
         existing);
}

} // namespace springdrive::app

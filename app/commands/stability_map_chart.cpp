#include "app/commands/stability_map_chart.h"

#include "app/asset_folder.h"
#include "app/commands/common_options.h"
#include "app/figures/figure.h"
#include "app/figures/gnuplot.h"

#include <cmath>
#include <sstream>

namespace springdrive {

namespace {

std::string axis_label(const StabilityParameter &parameter) {
    std::string label(parameter.symbol);
    if (const std::size_t line = label.find('_'); line != std::string::npos) {
        label = label.substr(0, line) + "_{" + label.substr(line + 1) + "}"; // for gnuplot
    }
    if (parameter.unit != "–") {
        label += "  (" + std::string(parameter.unit) + ")";
    }
    return label;
}

/// Half a cell, by which a picture reaches beyond the values at its sides.
void add_axis(ChartMarks &marks, const std::string &name, const MapAxis &axis) {
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

} // namespace

std::string stability_map_csv(const MapAxis &x, const MapAxis &y,
                              const std::vector<MapCell> &cells) {
    std::ostringstream csv;
    csv.precision(9);
    csv << x.parameter->name << ',' << y.parameter->name
        << ",largest_eigenvalue,stable_simulated,remaining_m_per_s\n";
    const std::size_t columns = x.values().size();
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const MapCell &cell = cells[i];
        csv << cell.x << ',' << cell.y << ',' << cell.eigenvalue << ',' << cell.stable << ','
            << cell.remaining_m_per_s << '\n';
        if ((i + 1) % columns == 0) {
            csv << '\n'; // as gnuplot wants the rows of a grid
        }
    }
    return csv.str();
}

void draw_stability_map(const std::filesystem::path &svg, const std::string &setting,
                        const MapAxis &x, const MapAxis &y, const std::vector<MapCell> &cells) {
    std::filesystem::path csv = svg;
    csv.replace_extension(".csv");
    write_output(csv.string(), [&](std::ostream &out) { out << stability_map_csv(x, y, cells); });
    ChartMarks marks;
    marks.add("heading", "Stability over " + std::string(x.parameter->symbol) + " and " +
                             std::string(y.parameter->symbol));
    marks.add("setting", setting);
    add_axis(marks, "x", x);
    add_axis(marks, "y", y);
    const std::filesystem::path folder =
        svg.parent_path().empty() ? std::filesystem::path(".") : svg.parent_path();
    draw({asset_folder() / "figures" / "stability_map.gnuplot", marks.assignments(), folder,
          csv.filename().string(), svg.filename().string()});
}

} // namespace springdrive

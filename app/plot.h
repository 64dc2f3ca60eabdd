// A live plot over time, drawn with ImGui's draw list.
#pragma once

#include <functional>
#include <imgui.h>
#include <vector>

namespace springdrive::app {

struct PlotLine {
    const char *label = "";
    ImVec4 colour;
    std::function<double(std::size_t)> value; ///< of sample i; NaN leaves a gap
};

/// A level drawn across the plot.
struct PlotLevel {
    double value = 0.0;
    const char *label = "";
};

struct Plot {
    const char *title = ""; ///< with the unit
    double span_s = 5.0;    ///< of the time axis, ending with the last sample
    double min_top = 1.0;   ///< the value axis runs from 0 to at least this
    double max_top = 1e9;   ///< and to at most this; larger values are clipped
    std::size_t samples = 0;
    std::function<double(std::size_t)> time_s; ///< of sample i, increasing
    std::vector<PlotLine> lines;
    std::vector<PlotLevel> levels; ///< drawn where they lie on the axis
};

/// Draws with this size at the cursor, and moves the cursor below. The tooltip shows time and
/// values.
void draw_plot(const Plot &plot, ImVec2 size);

} // namespace springdrive::app

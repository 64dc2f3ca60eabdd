// The legend of a plot: the names of its channels, which can be dragged to other plots.
#pragma once

#include "app/plots/plot_panel.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace springdrive::app {

/// Where the entries of a legend stand, row by row, from its corner on.
struct LegendLayout {
    std::vector<ImVec2> places; ///< of the first entries
    std::size_t hidden = 0;     ///< the number of the others, for which there is no room
    ImVec2 more;                ///< where that number is shown
    float height = 0.0F;
};

/// Of a plot's height: a legend does not need more.
inline constexpr float kLegendShare = 0.5F;

struct LegendRoom {
    ImVec2 size;       ///< of the legend, which has one row at least
    float row = 0.0F;  ///< height of a row
    float more = 0.0F; ///< width of the number of those that are hidden
};

/// @param widths  of the entries; one that is wider than the room has a row of its own
[[nodiscard]] LegendLayout legend_layout(const std::vector<float> &widths, const LegendRoom &room);

/// "+3 more", or "5 channels" where none of them is shown.
[[nodiscard]] std::string hidden_text(const LegendLayout &layout);
inline constexpr const char *kMaxHiddenText = "999 channels";

/// The channel's name, with what it is for where it is for something else than the others.
[[nodiscard]] std::string legend_text(const PlotSettings &settings, std::size_t channel);

/// " A 1  B 3  Δ 2 N": a channel's values at two times, and their difference; "–" where nothing is
/// kept.
[[nodiscard]] std::string values_under_cursors(std::size_t channel,
                                               const std::array<double, 2> &cursor_s,
                                               const record::ChannelStore &store, bool in_si);

/// The channels of a plot by their curves and names; a click removes one, a drag moves it to
/// another plot. Those that do not fit are counted, and named by a tooltip. @return its height
float draw_legend(Plot &plot, const PlotPanelState &state, const PlotSource &source, ImVec2 room);

/// The payload of ImGui's drag and drop.
struct DraggedChannel {
    std::size_t channel = 0;
    std::uint32_t plot = 0; ///< the id of the one whose legend it comes from; 0: from a list
};

/// Moves the channel into the plot; from a list, or if `copies`, it stays where it was, too.
void drop_channel(std::vector<Plot> &plots, Plot &plot, const DraggedChannel &dragged, bool copies);

} // namespace springdrive::app

// The panel of plots: several of them, with what they have in common: time, cursors and trigger.
#pragma once

#include "app/plots/plot.h"
#include "app/plots/plot_view.h"
#include "app/plots/stiffness_curves.h"
#include "app/widgets/rectangle.h"
#include "engine/session/session.h"
#include "engine/session/tuning_history.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

/// One of the plots, with what is remembered between frames.
struct Plot {
    std::uint32_t id = 0; ///< for ImGui, unchanged when others are closed
    PlotSettings settings;
    PlotCache cache;
    std::string searched;              ///< in the list of channels
    std::optional<ImVec2> box_from;    ///< corner of a range that is being drawn
    std::optional<std::size_t> cursor; ///< being dragged
    PlotArea area{};                   ///< in the last frame
};

/// What the plots are of: the present, or a record that is open.
struct PlotSubject {
    const record::ChannelStore &store;
    double servo_hz = 1000.0;
    std::optional<double> position_s{}; ///< where a record stands; empty: the present
    const PlotTrace *trace = nullptr;   ///< to be drawn behind, instead of the other slot's
    std::uint32_t number = 0;           ///< of the record; 0: the present
};

/// State of the panel between frames.
struct PlotPanelState {
    PlotPanelState();

    std::vector<Plot> plots;
    PlotView view;
    PlotTrigger trigger;
    PlotTriggerSettings typed_trigger; ///< in the trigger's menu
    StiffnessCurves stiffness;
    bool is_large = false;     ///< over the scene
    float height = 236.0F;     ///< at scale 1, otherwise
    std::string message;       ///< of the last export
    std::string timed_message; ///< the one that `message_until_s` is for
    double message_until_s = 0.0;
    std::uint32_t next_id = 1;

    /// What was shown with each slot's tuning when it was left.
    std::array<std::optional<PlotTrace>, 2> traces;
    bool shows_trace = true;
    session::TuningSlot slot = session::TuningSlot::a; ///< in the last frame
    bool is_of_record = false;                         ///< in the last frame
    std::uint32_t subject = 0;                         ///< its number

    /// A picture of this part of the window to write when the frame is complete.
    struct Picture {
        std::filesystem::path file;
        Rectangle where;
    };
    std::optional<Picture> picture;
};

/// A set of plots for a question, by name.
inline constexpr std::array<const char *, 7> kPlotSetLabels{
    "force and its direction", "figure 5, live", "figure 6, live",       "motors",
    "timing of the servo",     "stiffness",      "spectrum of the force"};
void choose_plot_set(PlotPanelState &state, std::size_t index);

/// @param slots  of tunings: the trace of the other one is shown faintly
void draw_plot_panel(session::Session &session, const PlotSubject &subject,
                     const session::TuningSlots &slots, PlotPanelState &state,
                     const Rectangle &place, float scale);

/// Holds the plots, and zooms their time about its middle and moves it.
/// @param span   of the new view, relative to the old one
/// @param shift  to later, in new spans
void move_in_time(PlotPanelState &state, const record::ChannelStore &live, double span,
                  double shift);

/// Stops the plots, or lets them follow the present again.
void toggle_hold(PlotPanelState &state, const record::ChannelStore &live);

// Parts of the panel.

/// Zooms, pans and reads values with the mouse; the previous item must cover the plot's area.
void use_mouse_on_plot(Plot &plot, PlotPanelState &state, const PlotSource &source,
                       const record::ChannelStore &live);

/// The menu of one plot: its kind, its channels, its units. False if it is to be closed.
[[nodiscard]] bool draw_plot_menu(Plot &plot);

/// The menu of the trigger.
void draw_trigger_menu(PlotPanelState &state, const record::ChannelStore &live);

/// Payload of ImGui's drag and drop: a DraggedChannel.
inline constexpr const char *kChannelPayload = "channel";

/// Each writes to a new file in the folder where the program was started, and says so in `message`.
void export_csv(PlotPanelState &state, const PlotSource &source);
void export_svg(PlotPanelState &state, const PlotSource &source, const Rectangle &where,
                float scale);
void export_png(PlotPanelState &state, const Rectangle &where);

/// Where each plot is drawn within `where`: those with many channels get more of a row.
[[nodiscard]] std::vector<Rectangle> plot_places(const Rectangle &where,
                                                 const std::vector<Plot> &plots);

/// What the panel draws of a plot apart from widgets, also into files.
PlotArea draw_contents(Canvas &canvas, const Rectangle &where, Plot &plot, PlotPanelState &state,
                       const PlotSource &source);

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

/// Angle and radius at a place in a polar plot: "30.0°, 1.5 N".
[[nodiscard]] std::string polar_text(const PlotArea &area, ImVec2 place,
                                     const PlotSettings &settings);

} // namespace springdrive::app

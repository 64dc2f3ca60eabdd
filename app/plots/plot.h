// A plot of telemetry channels: over time, as a spectrum, one against another, or as a histogram.
//
//   ChannelStore ──► the window of time that is shown ──► curves ──► Canvas
#pragma once

#include "app/plots/canvas.h"
#include "app/plots/oscilloscope.h"
#include "engine/record/channel_store.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

enum class PlotKind : std::uint8_t {
    time,
    spectrum,  ///< amplitude of a sine over frequency
    xy,        ///< the first channel to the right, the others up
    polar,     ///< the first channel is the angle, the others the radius
    histogram, ///< number of ticks over values
    stiffness, ///< of the coupling, over frequency: see StiffnessCurves
};

inline constexpr std::array<const char *, 6> kPlotKindLabels{"over time", "spectrum",  "x–y",
                                                             "polar",     "histogram", "stiffness"};

/// What the user chose for one plot.
struct PlotSettings {
    PlotKind kind = PlotKind::time;
    std::vector<std::size_t> channels;
    bool in_si = false;
    // Ranges after zooming, in shown units; otherwise the plot chooses. A time axis is common to
    // all plots, so it is not here. A polar plot has y only, for both directions.
    std::optional<Axis> x;
    std::optional<Axis> y;
};

/// What was shown with the other tuning, to be drawn faintly behind what is shown now.
struct PlotTrace {
    record::ChannelStore store;
    signals::TimeWindow window;
    std::string name; ///< of the tuning
};

/// The data of a frame.
struct PlotSource {
    const record::ChannelStore &store;
    double servo_hz = 1000.0;
    signals::TimeWindow window;
    /// The time that the axis counts from: now, if the view is live, else 0.
    double zero_s = 0.0;
    const PlotTrace *trace = nullptr; ///< may be null
    /// The time that belongs to the end of the trace.
    double trace_end_s = 0.0;
};

/// Results that take too long for every frame.
class PlotCache {
public:
    [[nodiscard]] const signals::Spectrum &spectrum(std::size_t channel, const PlotSource &source);
    [[nodiscard]] const signals::ValueHistogram &histogram(std::size_t channel,
                                                           const PlotSource &source);

    /// Call before each frame. @param wall_s  real time: results of a live view are renewed a few
    /// times per second
    void begin(double wall_s) { wall_s_ = wall_s; }

private:
    struct Entry {
        std::size_t channel = 0;
        std::uint64_t from = 0;
        std::uint64_t to = 0;
        double made_s = -1.0;
        std::optional<signals::Spectrum> spectrum;
        std::optional<signals::ValueHistogram> histogram;
    };

    Entry &entry(std::size_t channel, const PlotSource &source);
    /// Into `values_`.
    void copy_newest(const Entry &known, const PlotSource &source);

    double wall_s_ = 0.0;
    std::vector<Entry> entries_;
    std::vector<double> values_;
    std::uint64_t first_ = 0; ///< the row of the first of them
};

/// One curve: NaN in x or y interrupts it.
struct Curve {
    std::size_t channel = 0;
    std::vector<double> x;
    std::vector<double> y;
};

/// Draws the plot into `where`, without title. @return its area, for the mouse
PlotArea draw_plot(Canvas &canvas, const Rectangle &where, const PlotSettings &settings,
                   const PlotSource &source, PlotCache &cache);

/// The beginning of a horizontal line, with how far it goes, and its height.
struct SamplePlace {
    ImVec2 left; ///< its middle
    float length = 0.0F;
};

/// A short piece of a channel's curve as plots of this kind draw it, for legends.
void draw_sample(Canvas &canvas, const SamplePlace &place, const Stroke &stroke, PlotKind kind);

/// The unit of the values of these channels, if it is the same for all; else the units.
[[nodiscard]] std::string unit_title(const PlotSettings &settings);

/// Whether the first channel goes to the right, or is the angle, and so has no curve of its own.
[[nodiscard]] bool pairs_channels(PlotKind kind);
/// The same plot without its first channel.
[[nodiscard]] PlotSettings without_first(PlotSettings settings);

} // namespace springdrive::app

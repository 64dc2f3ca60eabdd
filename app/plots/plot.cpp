#include "app/plots/plot.h"

#include "app/plots/channels.h"
#include "app/widgets/widgets.h"
#include "engine/session/telemetry_history.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace springdrive::app {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

ShownUnit unit_of(std::size_t channel, const PlotSettings &settings) {
    return shown_unit(channel, settings.in_si);
}

/// The kept rows of a window of time: [from, to).
struct Rows {
    std::uint64_t from = 0;
    std::uint64_t to = 0;
};

Rows rows_of(const PlotSource &source) {
    const std::uint64_t from = source.store.row_at(source.window.from_s);
    const std::uint64_t after = source.store.row_at(source.window.to_s);
    // The last one is included.
    return {from, std::max(from, std::min(after + 1, source.store.end()))};
}

/// Smallest and largest value of some numbers.
struct Range {
    double minimum = std::numeric_limits<double>::infinity();
    double maximum = -std::numeric_limits<double>::infinity();

    void take(double value) {
        minimum = value < minimum ? value : minimum; // a NaN is neither smaller nor larger
        maximum = value > maximum ? value : maximum;
    }
};

/// The range of values that a plot chooses by itself. It holds 0 where that is near, so that a
/// small ripple is not taken for a large one. No value but 0 lies on its ends, where a curve would
/// be taken for cut off.
/// @param least  length
Axis chosen_axis(Range range, double least) {
    if (range.minimum <= range.maximum && range.maximum - range.minimum < least) {
        const bool starts_at_zero = range.minimum >= 0.0 && range.maximum < least;
        const double middle = 0.5 * (range.minimum + range.maximum);
        range.minimum = starts_at_zero ? 0.0 : middle - 0.5 * least;
        range.maximum = range.minimum + least;
    }
    if (range.minimum > 0.0 && range.minimum < 0.7 * range.maximum) {
        range.minimum = 0.0;
    }
    if (range.maximum < 0.0 && range.maximum > 0.7 * range.minimum) {
        range.maximum = 0.0;
    }
    const double room = 0.03 * (range.maximum - range.minimum);
    return round_axis(range.minimum == 0.0 ? 0.0 : range.minimum - room,
                      range.maximum == 0.0 ? 0.0 : range.maximum + room);
}

/// In shown units: the longest of the channels' least ranges.
double min_range(const PlotSettings &settings) {
    double least = 0.0;
    for (const std::size_t channel : settings.channels) {
        least = std::max(least, min_range_of_interest(channel) * unit_of(channel, settings).per_si);
    }
    return least;
}

/// Over curves, which stay visible faintly.
void draw_note(Canvas &canvas, ImVec2 corner, const ImVec4 &colour, const std::string &note) {
    const ImVec4 shade{0.11F, 0.12F, 0.15F, 0.75F};
    const float margin = 0.15F * text_height();
    canvas.fill(
        {{corner.x - margin, corner.y}, {text_width(note) + 2.0F * margin, 1.05F * text_height()}},
        shade);
    canvas.text(corner, colour, note);
}

struct ShownLevel {
    std::string label;
    float y = 0.0F;
};

/// The first level of the channels that is in the plot: several have the same one.
std::optional<ShownLevel> level_in(const PlotArea &area, const PlotSettings &settings) {
    for (const std::size_t channel : settings.channels) {
        if (const std::optional<PlotLevel> level = level_of(channel)) {
            const double value = level->value_si * unit_of(channel, settings).per_si;
            if (value > area.y.from && value < area.y.to) {
                return ShownLevel{std::string(level->label), area.place_y(value)};
            }
        }
    }
    return std::nullopt;
}

void draw_level(Canvas &canvas, const PlotArea &area, const ShownLevel &level) {
    const float left = area.where.corner.x;
    ImVec4 ink = kWarning;
    ink.w = 0.8F;
    canvas.line({left, level.y}, {left + area.where.size.x, level.y}, {ink, 1.0F, Dash::dashed});
}

void draw_curve(Canvas &canvas, const PlotArea &area, const Curve &curve, const Stroke &stroke) {
    std::vector<ImVec2> points;
    const auto flush = [&] {
        if (points.size() == 1) {
            canvas.dot(points.front(), 0.7F * stroke.width, stroke.colour);
        }
        canvas.polyline(points, stroke);
        points.clear();
    };
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
        if (!std::isfinite(curve.x[i]) || !std::isfinite(curve.y[i])) {
            flush();
        } else {
            points.push_back(area.place(curve.x[i], curve.y[i]));
        }
    }
    flush();
}

/// In the place of dashes where points are not in order, or turns would break dashes up: dots for
/// solid lines, crosses for dashed ones, and diamonds for dotted ones.
void draw_mark(Canvas &canvas, ImVec2 at, const Stroke &stroke) {
    const float arm = 0.15F * text_height();
    const Stroke thin{stroke.colour, 1.0F};
    switch (stroke.dash) {
    case Dash::solid:
        canvas.dot(at, 0.8F * stroke.width, stroke.colour);
        break;
    case Dash::dashed:
        canvas.line({at.x - arm, at.y - arm}, {at.x + arm, at.y + arm}, thin);
        canvas.line({at.x - arm, at.y + arm}, {at.x + arm, at.y - arm}, thin);
        break;
    case Dash::dotted: {
        const std::array<ImVec2, 5> corners{{{at.x - 1.3F * arm, at.y},
                                             {at.x, at.y - 1.3F * arm},
                                             {at.x + 1.3F * arm, at.y},
                                             {at.x, at.y + 1.3F * arm},
                                             {at.x - 1.3F * arm, at.y}}};
        canvas.polyline(corners, thin);
        break;
    }
    }
}

/// Of a curve with marks in the place of dashes.
Stroke line_between_marks(const Stroke &stroke) {
    return stroke.dash == Dash::solid ? stroke : Stroke{stroke.colour, 1.1F};
}

/// A mark on the first point in each cell of a grid: not too many, wherever the curve turns.
void draw_sparse_marks(Canvas &canvas, const PlotArea &area, const Curve &curve,
                       const Stroke &stroke) {
    const float cell = 2.0F * text_height();
    const auto index = [cell](float distance) {
        return static_cast<std::size_t>(std::max(0.0F, distance) / cell);
    };
    const std::size_t columns = index(area.where.size.x) + 1;
    std::vector<bool> is_marked(columns * (index(area.where.size.y) + 1));
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
        const ImVec2 at = area.place(curve.x[i], curve.y[i]);
        if (!std::isfinite(curve.x[i]) || !std::isfinite(curve.y[i]) || !area.where.contains(at)) {
            continue;
        }
        auto is_marked_here = is_marked.begin() + static_cast<std::ptrdiff_t>(
                                                      index(at.y - area.where.corner.y) * columns +
                                                      index(at.x - area.where.corner.x));
        if (!*is_marked_here) {
            draw_mark(canvas, at, stroke);
            *is_marked_here = true;
        }
    }
}

void draw_curves(Canvas &canvas, const PlotArea &area, const PlotSettings &settings,
                 const std::vector<Curve> &curves) {
    const std::optional<ShownLevel> level = level_in(area, settings);
    if (level) {
        draw_level(canvas, area, *level);
    }
    canvas.clip(area.where);
    for (const Curve &curve : curves) {
        const Stroke &stroke = look_of(curve.channel).stroke;
        if (settings.kind == PlotKind::xy && stroke.dash != Dash::solid) {
            draw_curve(canvas, area, curve, line_between_marks(stroke));
            draw_sparse_marks(canvas, area, curve, stroke);
        } else {
            draw_curve(canvas, area, curve, stroke);
        }
    }
    if (level) {
        draw_note(canvas,
                  {area.where.corner.x + 0.4F * text_height(), level->y - 1.1F * text_height()},
                  kWarning, level->label);
    }
    canvas.unclip();
}

/// The values of the curves within this part of the axis, or everywhere.
Range values_within(const std::vector<Curve> &curves, const std::optional<Axis> &x) {
    Range range;
    for (const Curve &curve : curves) {
        for (std::size_t i = 0; i < curve.x.size(); ++i) {
            if (!x || (curve.x[i] >= x->from && curve.x[i] <= x->to)) {
                range.take(curve.y[i]);
            } else if (i > 0 && std::min(curve.x[i - 1], curve.x[i]) < x->from &&
                       std::max(curve.x[i - 1], curve.x[i]) > x->to) { // passes through
                range.take(curve.y[i - 1]);
                range.take(curve.y[i]);
            }
        }
    }
    return range;
}

void say_nothing_to_show(Canvas &canvas, const PlotArea &area, std::string_view why) {
    const float margin = std::max(0.0F, 0.5F * (area.where.size.x - text_width(why)));
    canvas.text({area.where.corner.x + margin, area.where.corner.y + 0.4F * area.where.size.y},
                kFaintInk, why);
}

// --- over time ---

/// The first row of each of `columns` equal parts of the window, and the row behind the last.
std::vector<std::uint64_t> rows_of_columns(const PlotSource &source, int columns) {
    std::vector<std::uint64_t> rows;
    rows.reserve(static_cast<std::size_t>(columns) + 1);
    const double length_s = source.window.to_s - source.window.from_s;
    for (int i = 0; i <= columns; ++i) {
        rows.push_back(source.store.row_at(source.window.from_s + length_s * i / columns));
    }
    return rows;
}

/// Where a column of pixels holds several ticks, the curve passes through their minimum and
/// maximum: no peak is lost, however narrow the plot.
Curve curve_of_columns(std::size_t channel, const PlotSource &source, double per_si,
                       const std::vector<std::uint64_t> &rows) {
    Curve curve;
    curve.channel = channel;
    for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
        if (rows[i] == rows[i + 1]) {
            continue; // no tick here
        }
        const record::ChannelStore::Extremes extremes =
            source.store.extremes(channel, rows[i], rows[i + 1]);
        const double time_s = source.store.time_s(rows[i]) - source.zero_s;
        curve.x.insert(curve.x.end(), {time_s, time_s});
        const bool goes_up = curve.y.empty() || !(curve.y.back() > extremes.maximum * per_si);
        const double first = goes_up ? extremes.minimum : extremes.maximum;
        const double second = goes_up ? extremes.maximum : extremes.minimum;
        curve.y.insert(curve.y.end(), {first * per_si, second * per_si});
    }
    return curve;
}

Curve curve_of_ticks(std::size_t channel, const PlotSource &source, double per_si,
                     const Rows &rows) {
    Curve curve;
    curve.channel = channel;
    // From the tick before the window on, so that the line enters it.
    const std::uint64_t first = rows.from - (rows.from > source.store.begin() ? 1 : 0);
    for (std::uint64_t row = first; row < rows.to; ++row) {
        curve.x.push_back(source.store.time_s(row) - source.zero_s);
        curve.y.push_back(source.store.value(channel, row) * per_si);
    }
    return curve;
}

Range value_range(const PlotSettings &settings, const PlotSource &source, const Rows &rows) {
    Range range;
    for (const std::size_t channel : settings.channels) {
        const double per_si = unit_of(channel, settings).per_si;
        const record::ChannelStore::Extremes extremes =
            source.store.extremes(channel, rows.from, rows.to);
        range.take(extremes.minimum * per_si);
        range.take(std::min(extremes.maximum, greatest_of_interest(channel)) * per_si);
    }
    return range;
}

/// The trace as a source whose axis is that of `source`.
PlotSource source_of_trace(const PlotSource &source) {
    const double later_s = source.trace_end_s - source.trace->window.to_s;
    return {source.trace->store,
            source.servo_hz,
            {source.window.from_s - later_s, source.window.to_s - later_s},
            source.zero_s - later_s};
}

std::vector<Curve> curves_over_time(const PlotSettings &settings, const PlotSource &source,
                                    int columns) {
    const Rows rows = rows_of(source);
    const bool is_dense = rows.to - rows.from > 2 * static_cast<std::uint64_t>(columns);
    const std::vector<std::uint64_t> edges =
        is_dense ? rows_of_columns(source, columns) : std::vector<std::uint64_t>();
    std::vector<Curve> curves;
    for (const std::size_t channel : settings.channels) {
        const double per_si = unit_of(channel, settings).per_si;
        curves.push_back(is_dense ? curve_of_columns(channel, source, per_si, edges)
                                  : curve_of_ticks(channel, source, per_si, rows));
    }
    return curves;
}

void draw_trace(Canvas &canvas, const PlotArea &area, const PlotSettings &settings,
                const PlotSource &source) {
    canvas.clip(area.where);
    for (const Curve &curve :
         curves_over_time(settings, source_of_trace(source), static_cast<int>(area.where.size.x))) {
        Stroke stroke = look_of(curve.channel).stroke;
        stroke.colour.w *= 0.4F;
        draw_curve(canvas, area, curve, stroke);
    }
    canvas.unclip();
}

PlotArea draw_over_time(Canvas &canvas, const Rectangle &where, const PlotSettings &settings,
                        const PlotSource &source) {
    const Rows rows = rows_of(source);
    const Axis x{source.window.from_s - source.zero_s, source.window.to_s - source.zero_s};
    Range values = value_range(settings, source, rows);
    if (source.trace != nullptr) {
        const PlotSource trace = source_of_trace(source);
        const Range of_trace = value_range(settings, trace, rows_of(trace));
        values.take(of_trace.minimum);
        values.take(of_trace.maximum);
    }
    const PlotArea area =
        draw_axes(canvas, where, x, settings.y.value_or(chosen_axis(values, min_range(settings))),
                  "s", unit_title(settings));
    if (source.trace != nullptr) {
        draw_trace(canvas, area, settings, source);
    }
    draw_curves(
        canvas, area, settings,
        curves_over_time(settings, source, std::max(1, static_cast<int>(area.where.size.x))));
    if (source.trace != nullptr) {
        const std::string note = "faint: " + source.trace->name;
        draw_note(canvas,
                  {area.where.end().x - text_width(note) - 0.3F * text_height(),
                   area.where.corner.y + 0.1F * text_height()},
                  kFaintInk, note);
    }
    return area;
}

// --- spectrum ---

PlotArea draw_spectrum(Canvas &canvas, const Rectangle &where, const PlotSettings &settings,
                       const PlotSource &source, PlotCache &cache) {
    std::vector<Curve> curves;
    double first_Hz = 1.0;
    double last_Hz = 0.5 * source.servo_hz;
    for (const std::size_t channel : settings.channels) {
        const signals::Spectrum &spectrum = cache.spectrum(channel, source);
        const double per_si = unit_of(channel, settings).per_si;
        Curve curve;
        curve.channel = channel;
        // Without the mean, which a logarithmic axis cannot hold.
        for (std::size_t i = 1; i < spectrum.amplitude.size(); ++i) {
            const double amplitude = spectrum.amplitude[i] * per_si;
            curve.x.push_back(static_cast<double>(i) * spectrum.bin_Hz);
            curve.y.push_back(amplitude > 0.0 ? amplitude : kNone);
        }
        first_Hz = spectrum.amplitude.empty() ? first_Hz : spectrum.bin_Hz;
        last_Hz = curve.x.empty() ? last_Hz : curve.x.back();
        curves.push_back(std::move(curve));
    }
    const double most = values_within(curves, settings.x).maximum;
    const double top = most > 0.0 ? round_up(most) : 1.0;
    const Axis x = settings.x.value_or(Axis{first_Hz, last_Hz, true});
    const Axis y = settings.y.value_or(Axis{1e-5 * top, top, true});
    const PlotArea area =
        draw_axes(canvas, where, x, y, "Hz", "amplitude, " + unit_title(settings));
    if (!(values_within(curves, std::nullopt).maximum > 0.0)) {
        say_nothing_to_show(canvas, area, "no values to transform in this window");
    }
    draw_curves(canvas, area, settings, curves);
    return area;
}

// --- one against another ---

/// Of a longer window, a spectrum or histogram takes the newest ticks: some milliseconds of
/// computing.
constexpr std::uint64_t kMaxTicks = 1U << 17U;

/// At most so many points of all curves together, of a plot of one channel against another: every
/// n-th tick.
constexpr std::uint64_t kMaxPoints = 20'000;

/// Of all channels but the first. @pre there are two or more
std::vector<Curve> paired_curves(const PlotSettings &settings, const PlotSource &source,
                                 double angle_per_si) {
    const Rows rows = rows_of(source);
    const std::uint64_t most =
        std::max<std::uint64_t>(1, kMaxPoints / (settings.channels.size() - 1));
    const std::uint64_t step = std::max<std::uint64_t>(1, (rows.to - rows.from + most - 1) / most);
    std::vector<Curve> curves;
    for (std::size_t i = 1; i < settings.channels.size(); ++i) {
        Curve curve;
        curve.channel = settings.channels[i];
        const double per_si = unit_of(curve.channel, settings).per_si;
        for (std::uint64_t row = rows.from; row < rows.to; row += step) {
            curve.x.push_back(source.store.value(settings.channels.front(), row) * angle_per_si);
            curve.y.push_back(source.store.value(curve.channel, row) * per_si);
        }
        curves.push_back(std::move(curve));
    }
    return curves;
}

PlotArea draw_xy(Canvas &canvas, const Rectangle &where, const PlotSettings &settings,
                 const PlotSource &source) {
    if (settings.channels.size() < 2) {
        const PlotArea area = draw_axes(canvas, where, {}, {}, "", "");
        say_nothing_to_show(canvas, area, "choose two channels: the first goes to the right");
        return area;
    }
    const std::size_t first = settings.channels.front();
    const std::vector<Curve> curves =
        paired_curves(settings, source, unit_of(first, settings).per_si);
    Range of_x;
    for (const Curve &curve : curves) {
        for (std::size_t i = 0; i < curve.x.size(); ++i) {
            of_x.take(std::isnan(curve.y[i]) ? kNone : curve.x[i]);
        }
    }
    const PlotSettings of_values = without_first(settings);
    const Range of_y = values_within(curves, settings.x);
    const PlotArea area =
        draw_axes(canvas, where, settings.x.value_or(round_axis(of_x.minimum, of_x.maximum)),
                  settings.y.value_or(chosen_axis(of_y, min_range(of_values))),
                  look_of(first).label + ", " + std::string(unit_of(first, settings).name),
                  unit_title(of_values));
    draw_curves(canvas, area, of_values, curves);
    return area;
}

/// Circles at round radii, and rays each 30°.
void draw_polar_grid(Canvas &canvas, const PlotArea &area, double radius, const std::string &unit) {
    ImVec4 faint = kFaintInk;
    faint.w = 0.25F;
    for (const Tick &tick : ticks_of({0.0, radius}, 3)) {
        std::vector<ImVec2> circle;
        for (int i = 0; i <= 72; ++i) {
            const double angle = 2.0 * std::numbers::pi * i / 72;
            circle.push_back(
                area.place(tick.value * std::cos(angle), tick.value * std::sin(angle)));
        }
        canvas.polyline(circle, {faint, 1.0F});
        if (area.where.size.y > 6.0F * text_height()) {
            canvas.text(area.place(0.0, tick.value), kFaintInk, tick.label + " " + unit);
        }
    }
    for (int i = 0; i < 12; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / 12;
        canvas.line(area.place(0.0, 0.0),
                    area.place(radius * std::cos(angle), radius * std::sin(angle)), {faint, 1.0F});
    }
}

/// Marks only: what is not touched in order makes no line.
void draw_marks(Canvas &canvas, const PlotArea &area, const Curve &curve, const Stroke &stroke) {
    constexpr std::size_t kMaxMarks = 3000;
    for (std::size_t i = 0; i < curve.x.size(); i += 1 + curve.x.size() / kMaxMarks) {
        if (std::isfinite(curve.x[i]) && std::isfinite(curve.y[i])) {
            draw_mark(canvas, area.place(curve.x[i], curve.y[i]), stroke);
        }
    }
}

/// The largest square in the middle.
Rectangle square_within(const Rectangle &where) {
    const float side = std::max(1.0F, std::min(where.size.x, where.size.y));
    return {{where.corner.x + 0.5F * (where.size.x - side),
             where.corner.y + 0.5F * (where.size.y - side)},
            {side, side}};
}

PlotArea draw_polar(Canvas &canvas, const Rectangle &where, const PlotSettings &settings,
                    const PlotSource &source) {
    constexpr double kMargin = 1.08; // of the square around the circle
    std::vector<Curve> curves;
    Range radii;
    if (settings.channels.size() > 1) {
        curves = paired_curves(settings, source, 1.0);
        for (Curve &curve : curves) {
            const double most =
                greatest_of_interest(curve.channel) * unit_of(curve.channel, settings).per_si;
            for (std::size_t i = 0; i < curve.x.size(); ++i) {
                const double angle = curve.x[i];
                const double radius = std::min(std::abs(curve.y[i]), most);
                radii.take(std::isfinite(angle) && std::isfinite(radius) ? radius : kNone);
                curve.x[i] = radius * std::cos(angle);
                curve.y[i] = radius * std::sin(angle);
            }
        }
    }
    const double most = kMargin * (radii.maximum > 0.0 ? round_up(radii.maximum) : 1.0);
    const Axis axis = settings.y.value_or(Axis{-most, most});
    const PlotArea area{square_within(where), axis, axis};
    draw_polar_grid(canvas, area, axis.to / kMargin, unit_title(without_first(settings)));
    if (settings.channels.size() < 2) {
        say_nothing_to_show(canvas, area, "choose two channels: the first is the angle");
    }
    canvas.clip(area.where);
    for (const Curve &curve : curves) {
        draw_marks(canvas, area, curve, look_of(curve.channel).stroke);
    }
    canvas.unclip();
    return area;
}

// --- histogram ---

PlotArea draw_histogram(Canvas &canvas, const Rectangle &where, const PlotSettings &settings,
                        const PlotSource &source, PlotCache &cache) {
    std::vector<Curve> curves;
    Range of_x;
    std::uint64_t outside = 0;
    for (const std::size_t channel : settings.channels) {
        const signals::ValueHistogram &histogram = cache.histogram(channel, source);
        const double per_si = unit_of(channel, settings).per_si;
        Curve curve;
        curve.channel = channel;
        for (std::size_t bin = 0; bin < histogram.counts.size(); ++bin) {
            const auto count = static_cast<double>(histogram.counts[bin]);
            // A logarithmic axis begins at half a tick, so that one tick can be seen.
            const double height = count > 0.0 ? count : 0.5;
            curve.x.insert(curve.x.end(),
                           {histogram.edge(bin) * per_si, histogram.edge(bin + 1) * per_si});
            curve.y.insert(curve.y.end(), {height, height});
        }
        outside += histogram.below + histogram.above;
        of_x.take(histogram.from * per_si);
        of_x.take(histogram.to * per_si);
        curves.push_back(std::move(curve));
    }
    const Axis x = settings.x.value_or(round_axis(of_x.minimum, of_x.maximum));
    const double most = std::max(1.0, values_within(curves, settings.x).maximum);
    const Axis y = settings.y.value_or(Axis{0.5, round_up(most), true});
    const std::string beyond = outside > 0 ? fmt::format(", {} beyond the axis", outside) : "";
    const PlotArea area = draw_axes(canvas, where, x, y, unit_title(settings), "ticks" + beyond);
    draw_curves(canvas, area, {}, curves);
    return area;
}

} // namespace

std::string unit_title(const PlotSettings &settings) {
    std::vector<std::string_view> names;
    std::string title;
    for (const std::size_t channel : settings.channels) {
        const std::string_view name = unit_of(channel, settings).name;
        if (std::ranges::find(names, name) == names.end()) {
            title += (names.empty() ? "" : ", ") + std::string(name);
            names.push_back(name);
        }
    }
    return title;
}

bool pairs_channels(PlotKind kind) { return kind == PlotKind::xy || kind == PlotKind::polar; }

PlotSettings without_first(PlotSettings settings) {
    if (!settings.channels.empty()) {
        settings.channels.erase(settings.channels.begin());
    }
    return settings;
}

void draw_sample(Canvas &canvas, const SamplePlace &place, const Stroke &stroke, PlotKind kind) {
    const auto at = [&place](float share) {
        return ImVec2{place.left.x + share * place.length, place.left.y};
    };
    Stroke bold = stroke; // of one width, so that all can be seen
    bold.width = 2.0F;
    if (kind == PlotKind::polar) {
        for (const float share : {0.15F, 0.5F, 0.85F}) {
            draw_mark(canvas, at(share), bold);
        }
    } else if (kind == PlotKind::xy && stroke.dash != Dash::solid) {
        canvas.line(at(0.0F), at(1.0F), line_between_marks(stroke));
        draw_mark(canvas, at(0.5F), stroke);
    } else {
        canvas.line(at(0.0F), at(1.0F), bold);
    }
}

PlotArea draw_plot(Canvas &canvas, const Rectangle &where, const PlotSettings &settings,
                   const PlotSource &source, PlotCache &cache) {
    switch (settings.kind) {
    case PlotKind::spectrum:
        return draw_spectrum(canvas, where, settings, source, cache);
    case PlotKind::xy:
        return draw_xy(canvas, where, settings, source);
    case PlotKind::polar:
        return draw_polar(canvas, where, settings, source);
    case PlotKind::histogram:
        return draw_histogram(canvas, where, settings, source, cache);
    case PlotKind::time:
    case PlotKind::stiffness: // drawn by StiffnessCurves
        break;
    }
    return draw_over_time(canvas, where, settings, source);
}

PlotCache::Entry &PlotCache::entry(std::size_t channel, const PlotSource &source) {
    constexpr double kRenewed_s = 0.2;
    const Rows rows = rows_of(source);
    auto found = std::ranges::find(entries_, channel, &Entry::channel);
    if (found == entries_.end()) {
        entries_.emplace_back();
        entries_.back().channel = channel;
        found = entries_.end() - 1;
    }
    const bool is_same = found->from == rows.from && found->to == rows.to;
    if (!is_same && !(found->made_s >= 0.0 && wall_s_ - found->made_s < kRenewed_s)) {
        *found = {};
        found->channel = channel;
        found->from = rows.from;
        found->to = rows.to;
        found->made_s = wall_s_;
    }
    return *found;
}

void PlotCache::copy_newest(const Entry &known, const PlotSource &source) {
    first_ = std::max({known.from, source.store.begin(), known.to - std::min(known.to, kMaxTicks)});
    source.store.copy(known.channel, first_, std::max(first_, known.to), values_);
}

const signals::Spectrum &PlotCache::spectrum(std::size_t channel, const PlotSource &source) {
    Entry &known = entry(channel, source);
    if (!known.spectrum) {
        copy_newest(known, source);
        // By the ticks' own times: a view that is held may be from before a change of the rate.
        const double length_s =
            values_.size() > 1
                ? source.store.time_s(first_ + values_.size() - 1) - source.store.time_s(first_)
                : 0.0;
        const double rate_hz =
            length_s > 0.0 ? static_cast<double>(values_.size() - 1) / length_s : source.servo_hz;
        known.spectrum = signals::amplitude_spectrum(values_, rate_hz);
    }
    return *known.spectrum;
}

const signals::ValueHistogram &PlotCache::histogram(std::size_t channel, const PlotSource &source) {
    constexpr std::size_t kBins = 60;
    Entry &known = entry(channel, source);
    if (!known.histogram) {
        copy_newest(known, source);
        known.histogram = signals::histogram(values_, kBins);
    }
    return *known.histogram;
}

} // namespace springdrive::app

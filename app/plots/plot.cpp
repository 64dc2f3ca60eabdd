#include "app/plots/plot.h"

#include "app/plots/channel_look.h"
#include "app/widgets/look.h"
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
/// small ripple is not taken for a large one.
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
    return round_axis(range.minimum, range.maximum);
}

/// In shown units: the longest of the channels' least ranges.
double least_range(const PlotSettings &settings) {
    double least = 0.0;
    for (const std::size_t channel : settings.channels) {
        least =
            std::max(least, least_range_of_interest(channel) * unit_of(channel, settings).per_si);
    }
    return least;
}

void draw_levels(Canvas &canvas, const PlotArea &area, const PlotSettings &settings) {
    for (const std::size_t channel : settings.channels) {
        const std::optional<PlotLevel> level = level_of(channel);
        if (!level) {
            continue;
        }
        const double value = level->value_si * unit_of(channel, settings).per_si;
        if (value <= area.y.from || value >= area.y.to) {
            continue;
        }
        const float y = area.place_y(value);
        const float left = area.where.corner.x;
        ImVec4 ink = kWarning;
        ink.w = 0.8F;
        canvas.line({left, y}, {left + area.where.size.x, y}, {ink, 1.0F, Dash::dashed});
        canvas.text({left + 0.4F * text_height(), y - 1.1F * text_height()}, kWarning,
                    level->label);
        return; // several channels have the same one
    }
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

void draw_curves(Canvas &canvas, const PlotArea &area, const PlotSettings &settings,
                 const std::vector<Curve> &curves) {
    draw_levels(canvas, area, settings);
    canvas.clip(area.where);
    for (const Curve &curve : curves) {
        Stroke stroke = look_of(curve.channel).stroke;
        if (settings.kind == PlotKind::xy) { // its turns would break dashes up
            stroke.dash = Dash::solid;
        }
        draw_curve(canvas, area, curve, stroke);
    }
    canvas.unclip();
}

void say_nothing_to_show(Canvas &canvas, const PlotArea &area, std::string_view why) {
    canvas.text({area.where.corner.x + 0.5F * (area.where.size.x - text_width(why)),
                 area.where.corner.y + 0.4F * area.where.size.y},
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
    const std::string note = "faint: " + source.trace->name;
    canvas.text({area.where.corner.x + area.where.size.x - text_width(note) - 0.3F * text_height(),
                 area.where.corner.y + 0.1F * text_height()},
                kFaintInk, note);
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
        draw_axes(canvas, where, x, settings.y.value_or(chosen_axis(values, least_range(settings))),
                  "s", unit_title(settings));
    if (source.trace != nullptr) {
        draw_trace(canvas, area, settings, source);
    }
    draw_curves(
        canvas, area, settings,
        curves_over_time(settings, source, std::max(1, static_cast<int>(area.where.size.x))));
    return area;
}

// --- spectrum ---

PlotArea draw_spectrum(Canvas &canvas, const Rectangle &where, const PlotSettings &settings,
                       const PlotSource &source, PlotCache &cache) {
    std::vector<Curve> curves;
    Range range;
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
            range.take(amplitude);
        }
        first_Hz = spectrum.amplitude.empty() ? first_Hz : spectrum.bin_Hz;
        last_Hz = curve.x.empty() ? last_Hz : curve.x.back();
        curves.push_back(std::move(curve));
    }
    const bool is_empty = !(range.maximum > 0.0);
    const double top = is_empty ? 1.0 : round_up(range.maximum);
    const Axis x = settings.x.value_or(Axis{first_Hz, last_Hz, true});
    const Axis y = settings.y.value_or(Axis{1e-5 * top, top, true});
    const PlotArea area =
        draw_axes(canvas, where, x, y, "Hz", "amplitude, " + unit_title(settings));
    if (is_empty) {
        say_nothing_to_show(canvas, area, "no values to transform in this window");
    }
    draw_curves(canvas, area, settings, curves);
    return area;
}

// --- one against another ---

/// Of a longer window, a spectrum or histogram takes the newest ticks: some milliseconds of
/// computing.
constexpr std::uint64_t kMostTicks = 1U << 17U;

/// At most so many points: the newest are kept, and of them every n-th.
constexpr std::uint64_t kMostPoints = 20'000;

std::vector<Curve> paired_curves(const PlotSettings &settings, const PlotSource &source,
                                 double angle_per_si) {
    const Rows rows = rows_of(source);
    const std::uint64_t step =
        std::max<std::uint64_t>(1, (rows.to - rows.from + kMostPoints - 1) / kMostPoints);
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
    Range of_y;
    for (const Curve &curve : curves) {
        for (std::size_t i = 0; i < curve.x.size(); ++i) {
            if (!std::isnan(curve.y[i])) {
                of_x.take(curve.x[i]);
                of_y.take(curve.y[i]);
            }
        }
    }
    PlotSettings of_values = settings;
    of_values.channels.erase(of_values.channels.begin());
    const PlotArea area =
        draw_axes(canvas, where, settings.x.value_or(round_axis(of_x.minimum, of_x.maximum)),
                  settings.y.value_or(chosen_axis(of_y, least_range(of_values))),
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
        canvas.text(area.place(0.0, tick.value), kFaintInk, tick.label + " " + unit);
    }
    for (int i = 0; i < 12; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / 12;
        canvas.line(area.place(0.0, 0.0),
                    area.place(radius * std::cos(angle), radius * std::sin(angle)), {faint, 1.0F});
    }
}

/// Dots for what is drawn as a solid line over time, small crosses for what is dashed: what is not
/// touched in order makes no line.
void draw_marks(Canvas &canvas, const PlotArea &area, const Curve &curve, const Stroke &stroke) {
    constexpr std::size_t kMostMarks = 3000;
    const float arm = 0.15F * text_height();
    for (std::size_t i = 0; i < curve.x.size(); i += 1 + curve.x.size() / kMostMarks) {
        if (!std::isfinite(curve.x[i]) || !std::isfinite(curve.y[i])) {
            continue;
        }
        const ImVec2 at = area.place(curve.x[i], curve.y[i]);
        if (stroke.dash == Dash::solid) {
            canvas.dot(at, 0.8F * stroke.width, stroke.colour);
        } else {
            canvas.line({at.x - arm, at.y - arm}, {at.x + arm, at.y + arm}, {stroke.colour, 1.0F});
            canvas.line({at.x - arm, at.y + arm}, {at.x + arm, at.y - arm}, {stroke.colour, 1.0F});
        }
    }
}

PlotArea draw_polar(Canvas &canvas, const Rectangle &where, const PlotSettings &settings,
                    const PlotSource &source) {
    const float side = std::min(where.size.x, where.size.y);
    PlotArea area;
    area.where = {{where.corner.x + 0.5F * (where.size.x - side),
                   where.corner.y + 0.5F * (where.size.y - side)},
                  {side, side}};
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
    const double radius = radii.maximum > 0.0 ? round_up(radii.maximum) : 1.0;
    area.x = area.y = {-1.08 * radius, 1.08 * radius};
    PlotSettings of_values = settings;
    if (!of_values.channels.empty()) {
        of_values.channels.erase(of_values.channels.begin());
    }
    draw_polar_grid(canvas, area, radius, unit_title(of_values));
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
    double most = 1.0;
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
            most = std::max(most, count);
        }
        outside += histogram.below + histogram.above;
        of_x.take(histogram.from * per_si);
        of_x.take(histogram.to * per_si);
        curves.push_back(std::move(curve));
    }
    const Axis x = settings.x.value_or(round_axis(of_x.minimum, of_x.maximum));
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

PlotArea draw_axes(Canvas &canvas, const Rectangle &where, const Axis &x, const Axis &y,
                   const std::string &x_title, const std::string &y_title) {
    const float height = text_height();
    const std::vector<Tick> y_ticks =
        ticks_of(y, std::max(2, static_cast<int>(where.size.y / (2.2F * height))));
    float widest = 0.0F;
    for (const Tick &tick : y_ticks) {
        widest = std::max(widest, text_width(tick.label));
    }
    PlotArea area{{}, x, y};
    const float left = widest + 0.6F * height;
    area.where.corner = {where.corner.x + left, where.corner.y + 1.6F * height};
    area.where.size = {std::max(10.0F, where.size.x - left - 0.6F * height),
                       std::max(10.0F, where.size.y - 2.9F * height)};
    canvas.text(where.corner, kFaintInk, y_title);
    const auto grid = [](const Tick &tick) {
        ImVec4 faint = kFaintInk;
        faint.w = tick.is_minor ? 0.07F : 0.2F;
        return Stroke{faint, 1.0F};
    };
    const float bottom = area.where.corner.y + area.where.size.y;
    const float right = area.where.corner.x + area.where.size.x;
    for (const Tick &tick : y_ticks) {
        const float place = area.place_y(tick.value);
        canvas.line({area.where.corner.x, place}, {right, place}, grid(tick));
        canvas.text(
            {area.where.corner.x - text_width(tick.label) - 0.3F * height, place - 0.5F * height},
            kFaintInk, tick.label);
    }
    const float title_width = x_title.empty() ? 0.0F : text_width(x_title) + height;
    for (const Tick &tick :
         ticks_of(x, std::max(2, static_cast<int>(area.where.size.x / (4.5F * height))))) {
        const float place = area.place_x(tick.value);
        canvas.line({place, area.where.corner.y}, {place, bottom}, grid(tick));
        const float width = text_width(tick.label);
        if (place + 0.5F * width < right - title_width) {
            canvas.text({place - 0.5F * width, bottom + 0.1F * height}, kFaintInk, tick.label);
        }
    }
    canvas.text({right - text_width(x_title), bottom + 0.1F * height}, kFaintInk, x_title);
    return area;
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

const signals::Spectrum &PlotCache::spectrum(std::size_t channel, const PlotSource &source) {
    Entry &known = entry(channel, source);
    if (!known.spectrum) {
        const std::uint64_t from =
            std::max({known.from, source.store.begin(), known.to - std::min(known.to, kMostTicks)});
        source.store.copy(channel, from, std::max(from, known.to), values_);
        // By the ticks' own times: a view that is held may be from before a change of the rate.
        const double length_s =
            values_.size() > 1
                ? source.store.time_s(from + values_.size() - 1) - source.store.time_s(from)
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
        const std::uint64_t from =
            std::max({known.from, source.store.begin(), known.to - std::min(known.to, kMostTicks)});
        source.store.copy(channel, from, std::max(from, known.to), values_);
        known.histogram = signals::automatic_histogram(values_, signals::Coverage::most, kBins);
    }
    return *known.histogram;
}

} // namespace springdrive::app

#include "app/plots/canvas.h"

#include "app/widgets/widgets.h"
#include "base/text.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>

namespace springdrive::app {

namespace {

/// Lengths of a dash and of the gap behind it, in line widths.
struct DashLengths {
    float drawn;
    float gap;
};

DashLengths lengths_of(Dash dash) {
    return dash == Dash::dotted ? DashLengths{1.5F, 2.5F} : DashLengths{6.0F, 4.0F};
}

ImVec2 between(ImVec2 from, ImVec2 to, float share) {
    return {from.x + share * (to.x - from.x), from.y + share * (to.y - from.y)};
}

/// Calls draw(points) for each dash along a line.
template <typename Draw>
void for_each_dash(std::span<const ImVec2> points, const DashLengths &lengths,
                   std::vector<ImVec2> &dash, Draw &&draw) {
    bool is_drawn = true;
    float left = lengths.drawn;
    dash.assign(1, points.front());
    for (std::size_t i = 1; i < points.size(); ++i) {
        const ImVec2 from = points[i - 1];
        const ImVec2 to = points[i];
        const float length = std::hypot(to.x - from.x, to.y - from.y);
        float done = 0.0F;
        while (length - done > left) {
            done += left;
            const ImVec2 turn = between(from, to, done / length);
            if (is_drawn) {
                dash.push_back(turn);
                draw(dash);
            }
            dash.assign(1, turn);
            is_drawn = !is_drawn;
            left = is_drawn ? lengths.drawn : lengths.gap;
        }
        left -= length - done;
        dash.push_back(to);
    }
    if (is_drawn && dash.size() > 1) {
        draw(dash);
    }
}

/// The attribute of a colour, with its opacity.
std::string paint(const char *attribute, const ImVec4 &colour) {
    const auto byte = [](float part) { return static_cast<int>(std::lround(255.0F * part)); };
    return fmt::format("{0}=\"rgb({1},{2},{3})\" {0}-opacity=\"{4:.2f}\"", attribute,
                       byte(colour.x), byte(colour.y), byte(colour.z), colour.w);
}

} // namespace

float text_height() { return ImGui::GetFontSize(); }

float text_width(std::string_view text) {
    return ImGui::CalcTextSize(text.data(), text.data() + text.size()).x;
}

void ScreenCanvas::polyline(std::span<const ImVec2> points, const Stroke &stroke) {
    if (points.size() < 2) {
        return;
    }
    const ImU32 colour = ImGui::ColorConvertFloat4ToU32(stroke.colour);
    const float width = stroke.width * scale_;
    // Piece by piece: the mitred corners of a polyline reach far beyond the peaks of noise, and one
    // polyline cannot have more points than 16 bits count.
    const auto draw = [&](std::span<const ImVec2> line) {
        for (std::size_t i = 1; i < line.size(); ++i) {
            list_.AddPolyline(&line[i - 1], 2, colour, ImDrawFlags_None, width);
        }
    };
    if (stroke.dash == Dash::solid) {
        draw(points);
        return;
    }
    DashLengths lengths = lengths_of(stroke.dash);
    lengths.drawn *= std::max(width, scale_);
    lengths.gap *= std::max(width, scale_);
    for_each_dash(points, lengths, dash_, draw);
}

void ScreenCanvas::fill(const Rectangle &where, const ImVec4 &colour) {
    list_.AddRectFilled(where.corner, where.end(), ImGui::ColorConvertFloat4ToU32(colour));
}

void ScreenCanvas::dot(ImVec2 middle, float radius, const ImVec4 &colour) {
    list_.AddCircleFilled(middle, radius * scale_, ImGui::ColorConvertFloat4ToU32(colour));
}

void ScreenCanvas::text(ImVec2 corner, const ImVec4 &colour, std::string_view text) {
    list_.AddText(corner, ImGui::ColorConvertFloat4ToU32(colour), text.data(),
                  text.data() + text.size());
}

void ScreenCanvas::clip(const Rectangle &where) {
    list_.PushClipRect(where.corner, where.end(), true);
}

void ScreenCanvas::unclip() { list_.PopClipRect(); }

SvgCanvas::SvgCanvas(const Rectangle &where, float scale) : where_(where), scale_(scale) {}

void SvgCanvas::polyline(std::span<const ImVec2> points, const Stroke &stroke) {
    if (points.size() < 2) {
        return;
    }
    body_ += R"(<polyline fill="none" stroke-linejoin="round" points=")";
    for (const ImVec2 &point : points) {
        fmt::format_to(std::back_inserter(body_), "{:.2f},{:.2f} ", point.x - where_.corner.x,
                       point.y - where_.corner.y);
    }
    const float width = stroke.width * scale_;
    fmt::format_to(std::back_inserter(body_), R"(" {} stroke-width="{:.2f}")",
                   paint("stroke", stroke.colour), width);
    if (stroke.dash != Dash::solid) {
        const DashLengths lengths = lengths_of(stroke.dash);
        fmt::format_to(std::back_inserter(body_), " stroke-dasharray=\"{:.1f} {:.1f}\"",
                       lengths.drawn * std::max(width, scale_),
                       lengths.gap * std::max(width, scale_));
    }
    body_ += "/>\n";
}

void SvgCanvas::fill(const Rectangle &where, const ImVec4 &colour) {
    fmt::format_to(std::back_inserter(body_),
                   "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" {}/>\n",
                   where.corner.x - where_.corner.x, where.corner.y - where_.corner.y, where.size.x,
                   where.size.y, paint("fill", colour));
}

void SvgCanvas::dot(ImVec2 middle, float radius, const ImVec4 &colour) {
    fmt::format_to(std::back_inserter(body_),
                   "<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.2f}\" {}/>\n",
                   middle.x - where_.corner.x, middle.y - where_.corner.y, radius * scale_,
                   paint("fill", colour));
}

void SvgCanvas::text(ImVec2 corner, const ImVec4 &colour, std::string_view text) {
    // ImGui places the top of a line, SVG its base line.
    constexpr float kAscent = 0.8F;
    fmt::format_to(std::back_inserter(body_), "<text x=\"{:.2f}\" y=\"{:.2f}\" {}>{}</text>\n",
                   corner.x - where_.corner.x, corner.y - where_.corner.y + kAscent * text_height(),
                   paint("fill", colour), xml_text(text));
}

void SvgCanvas::clip(const Rectangle &where) {
    ++clips_;
    fmt::format_to(std::back_inserter(body_),
                   "<clipPath id=\"clip{0}\"><rect x=\"{1:.2f}\" y=\"{2:.2f}\" width=\"{3:.2f}\" "
                   "height=\"{4:.2f}\"/></clipPath>\n<g clip-path=\"url(#clip{0})\">\n",
                   clips_, where.corner.x - where_.corner.x, where.corner.y - where_.corner.y,
                   where.size.x, where.size.y);
}

void SvgCanvas::unclip() { body_ += "</g>\n"; }

std::string SvgCanvas::svg() const {
    // The height of ImGui's text is that of a line, somewhat more than SVG's size of the font.
    constexpr float kSizeOfFont = 0.86F;
    return fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" "
                       "height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
                       "font-family=\"DejaVu Sans, sans-serif\" font-size=\"{2:.1f}\" "
                       "xml:space=\"preserve\">\n{3}</svg>\n",
                       where_.size.x, where_.size.y, kSizeOfFont * text_height(), body_);
}

namespace {

constexpr double kRoundOff = 1e-9; // of a step

/// Far below any span that can be shown; keeps an axis from collapsing to a point.
double min_length(double from, double to) {
    return 1e-9 * std::max({std::abs(from), std::abs(to), 1e-6});
}

/// Whether an axis can be drawn and labelled: zooming and moving end before that.
bool is_usable(const Axis &axis) {
    constexpr double kMax = 1e100;
    if (!(std::abs(axis.from) < kMax && std::abs(axis.to) < kMax)) {
        return false; // a NaN, too
    }
    if (axis.is_logarithmic) {
        return axis.from > 1.0 / kMax && axis.to / axis.from > 1.0 + 1e-9;
    }
    return axis.to - axis.from > min_length(axis.from, axis.to);
}

std::vector<Tick> linear_ticks(const Axis &axis, int most) {
    const double length = axis.to - axis.from;
    const double step = round_up(length / std::max(1, most));
    std::vector<Tick> ticks;
    const double first = std::ceil(axis.from / step - kRoundOff);
    const double last = std::floor(axis.to / step + kRoundOff);
    for (int i = 0; i <= static_cast<int>(last - first); ++i) {
        const double value = (first + i) * step;
        ticks.push_back({value, number_at_step(value, step)});
    }
    return ticks;
}

/// Powers of ten are labelled, or every second or third of them; 2 to 9 are not, unless there are
/// less than two powers.
std::vector<Tick> logarithmic_ticks(const Axis &axis, int most) {
    const int first = static_cast<int>(std::floor(std::log10(axis.from) + kRoundOff));
    const int last = static_cast<int>(std::ceil(std::log10(axis.to) - kRoundOff));
    const int labelled_each = std::max(1, (last - first + most) / std::max(1, most));
    const bool labels_all = std::log10(axis.to / axis.from) < 1.3;
    std::vector<Tick> ticks;
    bool has_label = false;
    for (int power = first; power <= last; ++power) {
        for (int digit = 1; digit <= 9; ++digit) {
            const double value = digit * std::pow(10.0, power);
            if (value < axis.from * (1.0 - kRoundOff) || value > axis.to * (1.0 + kRoundOff)) {
                continue;
            }
            const bool is_labelled = digit == 1 ? (power - first) % labelled_each == 0
                                                : labels_all && (digit == 2 || digit == 5);
            has_label = has_label || is_labelled;
            ticks.push_back(
                {value, is_labelled ? fmt::format("{:g}", value) : std::string(), digit != 1});
        }
    }
    // Between two round values: as on an axis that is not logarithmic.
    return has_label ? ticks : linear_ticks(axis, most);
}

/// Where there is no room for labels beside the curves: a frame.
PlotArea draw_frame(Canvas &canvas, const Rectangle &where, const Axis &x, const Axis &y) {
    const PlotArea area{
        {where.corner, {std::max(1.0F, where.size.x), std::max(1.0F, where.size.y)}}, x, y};
    const float right = where.corner.x + area.where.size.x;
    const float bottom = where.corner.y + area.where.size.y;
    ImVec4 faint = kFaintInk;
    faint.w = 0.2F;
    const std::array<ImVec2, 5> corners{{where.corner,
                                         {right, where.corner.y},
                                         {right, bottom},
                                         {where.corner.x, bottom},
                                         where.corner}};
    canvas.polyline(corners, {faint, 1.0F});
    return area;
}

} // namespace

double Axis::share(double value) const {
    if (is_logarithmic) {
        return std::log(std::max(value, 1e-300) / from) / std::log(to / from);
    }
    return (value - from) / (to - from);
}

double Axis::value(double share) const {
    return is_logarithmic ? from * std::pow(to / from, share) : from + share * (to - from);
}

Axis Axis::zoomed(double share, double factor) const {
    Axis result = *this;
    result.from = value(share * (1.0 - factor));
    result.to = value(share + (1.0 - share) * factor);
    return is_usable(result) ? result : *this;
}

Axis Axis::moved(double share) const {
    Axis result = *this;
    result.from = value(share);
    result.to = value(1.0 + share);
    return is_usable(result) ? result : *this;
}

double round_up(double value) {
    const double decade = std::pow(10.0, std::floor(std::log10(value)));
    for (const double factor : {1.0, 2.0, 5.0}) {
        if (factor * decade >= value * (1.0 - kRoundOff)) {
            return factor * decade;
        }
    }
    return 10.0 * decade;
}

Axis round_axis(double minimum, double maximum) {
    if (!(minimum <= maximum) || !std::isfinite(minimum) || !std::isfinite(maximum)) {
        return {0.0, 1.0};
    }
    if (maximum - minimum <= min_length(minimum, maximum)) {
        const double margin = minimum == 0.0 ? 1.0 : 0.1 * std::abs(minimum);
        return {minimum - margin, maximum + margin};
    }
    const double step = round_up(0.125 * (maximum - minimum));
    return {step * std::floor(minimum / step + kRoundOff),
            step * std::ceil(maximum / step - kRoundOff)};
}

std::vector<Tick> ticks_of(const Axis &axis, int most) {
    if (!(axis.to > axis.from)) {
        return {};
    }
    return axis.is_logarithmic ? logarithmic_ticks(axis, most) : linear_ticks(axis, most);
}

std::string number_at_step(double value, double step) {
    const double magnitude = std::max(std::abs(value), step);
    if (magnitude >= 1e6 || magnitude < 1e-4) {
        // Digits down to the step.
        const auto exponent = [](double number) {
            return static_cast<int>(std::floor(std::log10(number) + kRoundOff));
        };
        const int digits = exponent(magnitude) - exponent(step);
        return fmt::format("{:.{}e}", value, std::clamp(digits, 0, 15));
    }
    const int decimals = static_cast<int>(std::ceil(-std::log10(step) - kRoundOff));
    return fmt::format("{:.{}f}", value == 0.0 ? 0.0 : value, std::clamp(decimals, 0, 15));
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
    const float left = widest + 0.6F * height;
    const ImVec2 size{where.size.x - left - 0.6F * height, where.size.y - 2.9F * height};
    if (size.x < 4.0F * height || size.y < 1.5F * height) {
        return draw_frame(canvas, where, x, y);
    }
    const PlotArea area{{{where.corner.x + left, where.corner.y + 1.6F * height}, size}, x, y};
    canvas.text(where.corner, kFaintInk, y_title);
    const auto grid = [](const Tick &tick) {
        ImVec4 faint = kFaintInk;
        faint.w = tick.is_minor ? 0.07F : 0.2F;
        return Stroke{faint, 1.0F};
    };
    const float bottom = area.where.end().y;
    const float right = area.where.end().x;
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
            canvas.text({std::max(where.corner.x, place - 0.5F * width), bottom + 0.1F * height},
                        kFaintInk, tick.label);
        }
    }
    canvas.text({right - text_width(x_title), bottom + 0.1F * height}, kFaintInk, x_title);
    return area;
}

} // namespace springdrive::app

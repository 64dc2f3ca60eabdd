#include "app/plots/canvas.h"

#include "base/text.h"

#include <algorithm>
#include <fmt/core.h>

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

} // namespace springdrive::app

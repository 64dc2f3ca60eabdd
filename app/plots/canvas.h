// What plots are drawn on: the window, or an SVG file that looks the same; and their axes: from
// values to places and back, and the values that are labelled.
#pragma once

#include "app/widgets/rectangle.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app {

/// Told apart without colour, too.
enum class Dash : std::uint8_t { solid, dashed, dotted };

struct Stroke {
    ImVec4 colour;
    float width = 1.0F; ///< at scale 1
    Dash dash = Dash::solid;
};

/// Places are in the window's units. Widths follow the scale of text.
class Canvas {
public:
    Canvas() = default;
    Canvas(const Canvas &) = delete;
    Canvas &operator=(const Canvas &) = delete;
    virtual ~Canvas() = default;

    virtual void polyline(std::span<const ImVec2> points, const Stroke &stroke) = 0;
    virtual void fill(const Rectangle &where, const ImVec4 &colour) = 0;
    virtual void dot(ImVec2 middle, float radius, const ImVec4 &colour) = 0;
    virtual void text(ImVec2 corner, const ImVec4 &colour, std::string_view text) = 0;
    /// Restricts what follows, until `unclip`.
    virtual void clip(const Rectangle &where) = 0;
    virtual void unclip() = 0;

    void line(ImVec2 from, ImVec2 to, const Stroke &stroke) {
        const std::array<ImVec2, 2> ends{from, to};
        polyline(ends, stroke);
    }
};

/// Height of text, the unit of all distances in a plot.
[[nodiscard]] float text_height();
[[nodiscard]] float text_width(std::string_view text);

/// On an ImGui draw list, at a scale of text and lines.
class ScreenCanvas final : public Canvas {
public:
    ScreenCanvas(ImDrawList &list, float scale) : list_(list), scale_(scale) {}

    void polyline(std::span<const ImVec2> points, const Stroke &stroke) override;
    void fill(const Rectangle &where, const ImVec4 &colour) override;
    void dot(ImVec2 middle, float radius, const ImVec4 &colour) override;
    void text(ImVec2 corner, const ImVec4 &colour, std::string_view text) override;
    void clip(const Rectangle &where) override;
    void unclip() override;

private:
    ImDrawList &list_;
    float scale_;
    std::vector<ImVec2> dash_;
};

/// Collects a picture of `where`. For use on the window's thread, as text is measured by ImGui.
class SvgCanvas final : public Canvas {
public:
    SvgCanvas(const Rectangle &where, float scale);

    void polyline(std::span<const ImVec2> points, const Stroke &stroke) override;
    void fill(const Rectangle &where, const ImVec4 &colour) override;
    void dot(ImVec2 middle, float radius, const ImVec4 &colour) override;
    void text(ImVec2 corner, const ImVec4 &colour, std::string_view text) override;
    void clip(const Rectangle &where) override;
    void unclip() override;

    /// The whole file.
    [[nodiscard]] std::string svg() const;

private:
    Rectangle where_;
    float scale_;
    std::string body_;
    int clips_ = 0;
};

struct Axis {
    double from = 0.0;
    double to = 1.0;
    bool is_logarithmic = false; ///< then both ends are positive

    /// 0 at `from`, 1 at `to`.
    [[nodiscard]] double share(double value) const;
    [[nodiscard]] double value(double share) const;

    /// The same axis with `share` of it at the same place, and `factor` times as long.
    [[nodiscard]] Axis zoomed(double share, double factor) const;
    /// Moved by this share of its length. Both leave the axis as it is beyond what can be labelled.
    [[nodiscard]] Axis moved(double share) const;

    friend bool operator==(const Axis &, const Axis &) = default;
};

/// The next value of 1, 2 or 5 times a power of ten that is not below a positive `value`.
[[nodiscard]] double round_up(double value);

/// An axis that holds these values, with round ends; around a single value, or around 0 for none.
[[nodiscard]] Axis round_axis(double minimum, double maximum);

struct Tick {
    double value;
    std::string label;     ///< may be empty, on logarithmic axes
    bool is_minor = false; ///< between the powers of ten of a logarithmic axis
};

/// Round values on the axis, at most `most` of them labelled.
[[nodiscard]] std::vector<Tick> ticks_of(const Axis &axis, int most);

/// A number with as many digits as tell values apart that differ by `step`.
[[nodiscard]] std::string number_at_step(double value, double step);

/// The area of a plot within its axes.
class PlotArea {
public:
    Rectangle where;
    Axis x;
    Axis y;

    [[nodiscard]] float place_x(double value) const {
        return where.corner.x + drawable(x.share(value)) * where.size.x;
    }
    [[nodiscard]] float place_y(double value) const {
        return where.corner.y + (1.0F - drawable(y.share(value))) * where.size.y;
    }
    [[nodiscard]] ImVec2 place(double x_value, double y_value) const {
        return {place_x(x_value), place_y(y_value)};
    }
    [[nodiscard]] double x_at(float place) const {
        return x.value((place - where.corner.x) / where.size.x);
    }
    [[nodiscard]] double y_at(float place) const {
        return y.value(1.0F - (place - where.corner.y) / where.size.y);
    }

private:
    /// Far outside, but a number that can be drawn.
    [[nodiscard]] static float drawable(double share) {
        return static_cast<float>(std::clamp(share, -1e4, 1e4));
    }
};

/// Axes with ticks, and their titles; without the room for them, only a frame.
/// @return the area within
PlotArea draw_axes(Canvas &canvas, const Rectangle &where, const Axis &x, const Axis &y,
                   const std::string &x_title, const std::string &y_title);

} // namespace springdrive::app

// What plots are drawn on: the window, or an SVG file that looks the same.
#pragma once

#include "app/widgets/rectangle.h"

#include <imgui.h>

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

} // namespace springdrive::app

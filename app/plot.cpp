#include "app/plot.h"

#include "app/widgets/look.h"
#include "base/print.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace springdrive::app {

namespace {

/// The next value of 1, 2 or 5 times a power of ten, not below `value`.
double round_up(double value) {
    const double decade = std::pow(10.0, std::floor(std::log10(value)));
    for (const double factor : {1.0, 2.0, 5.0}) {
        if (factor * decade >= value * (1.0 - 1e-9)) {
            return factor * decade;
        }
    }
    return 10.0 * decade;
}

ImU32 packed(ImVec4 colour, float alpha = 1.0F) {
    colour.w *= alpha;
    return ImGui::ColorConvertFloat4ToU32(colour);
}

/// The plot area on the screen, and the values at its borders.
struct PlotFrame {
    ImVec2 lower; ///< bottom left
    ImVec2 upper; ///< top right
    double first_s = 0.0;
    double last_s = 1.0;
    double top = 1.0;

    [[nodiscard]] float x(double time_s) const {
        const double share = (time_s - first_s) / (last_s - first_s);
        return lower.x + static_cast<float>(share) * (upper.x - lower.x);
    }
    [[nodiscard]] float y(double value) const {
        const double share = std::clamp(value / top, 0.0, 1.0);
        return lower.y + static_cast<float>(share) * (upper.y - lower.y);
    }
};

std::size_t first_visible(const Plot &plot, double first_s) {
    std::size_t low = 0;
    std::size_t high = plot.samples;
    while (low < high) {
        const std::size_t middle = (low + high) / 2;
        if (plot.time_s(middle) < first_s) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

double max_value(const Plot &plot, std::size_t first) {
    double maximum = 0.0;
    for (const PlotLine &line : plot.lines) {
        for (std::size_t i = first; i < plot.samples; ++i) {
            const double value = line.value(i);
            maximum = value > maximum ? value : maximum; // a NaN is never greater
        }
    }
    return maximum;
}

void draw_axes(ImDrawList &list, const Plot &plot, const PlotFrame &frame) {
    constexpr int kDivisions = 4;
    const float font = ImGui::GetFontSize();
    std::array<char, 32> text{};
    for (int i = 0; i <= kDivisions; ++i) {
        const double value = frame.top * i / kDivisions;
        const float y = frame.y(value);
        list.AddLine({frame.lower.x, y}, {frame.upper.x, y}, packed(kFaintInk, 0.22F));
        print(text, "{:g}", value);
        const float width = ImGui::CalcTextSize(text.data()).x;
        list.AddText({frame.lower.x - width - 0.4F * font, y - 0.5F * font}, packed(kFaintInk),
                     text.data());
    }
    const int step_s = frame.upper.x - frame.lower.x > 24.0F * font ? 1 : 2;
    for (int back_s = 0; back_s <= plot.span_s; back_s += step_s) {
        const float x = frame.x(frame.last_s - back_s);
        list.AddLine({x, frame.upper.y}, {x, frame.lower.y}, packed(kFaintInk, 0.12F));
        if (back_s == 0) {
            print(text, "now");
        } else {
            print(text, "\u2212{} s", back_s);
        }
        const float width = ImGui::CalcTextSize(text.data()).x;
        list.AddText({x - (back_s == 0 ? width : 0.5F * width), frame.lower.y + 0.15F * font},
                     packed(kFaintInk), text.data());
    }
}

void draw_levels(ImDrawList &list, const Plot &plot, const PlotFrame &frame) {
    const float font = ImGui::GetFontSize();
    for (const PlotLevel &level : plot.levels) {
        if (level.value > frame.top) {
            continue;
        }
        const float y = frame.y(level.value);
        const float dash = 0.4F * font;
        const int dashes = static_cast<int>((frame.upper.x - frame.lower.x) / (2.0F * dash));
        for (int i = 0; i < dashes; ++i) {
            const float x = frame.lower.x + 2.0F * dash * static_cast<float>(i);
            list.AddLine({x, y}, {x + dash, y}, packed(kWarning, 0.8F));
        }
        list.AddText({frame.lower.x + 0.4F * font, y - 1.1F * font}, packed(kWarning, 0.9F),
                     level.label);
    }
}

/// One vertical line per pixel column, from the minimum to the maximum value there, so that no peak
/// of samples at 1 kHz is lost in a narrow plot.
void draw_line(ImDrawList &list, const Plot &plot, const PlotLine &line, const PlotFrame &frame,
               std::size_t first) {
    const ImU32 colour = packed(line.colour);
    float column = -1.0F;
    double low = 0.0;
    double high = 0.0;
    ImVec2 before{-1.0F, 0.0F};
    const auto flush = [&] {
        if (column < 0.0F) {
            return;
        }
        const float y_low = frame.y(low);
        const float y_high = frame.y(high);
        const float y_middle = 0.5F * (y_low + y_high);
        if (y_low - y_high > 1.5F) {
            list.AddLine({column, y_low}, {column, y_high}, colour, 1.5F);
        }
        if (before.x >= 0.0F) {
            list.AddLine(before, {column, y_middle}, colour, 1.8F);
        }
        before = {column, y_middle};
        column = -1.0F;
    };
    for (std::size_t i = first; i < plot.samples; ++i) {
        const double value = line.value(i);
        if (std::isnan(value)) {
            flush();
            before.x = -1.0F;
            continue;
        }
        const float x = std::floor(frame.x(plot.time_s(i)));
        if (x != column) {
            flush();
            column = x;
            low = high = value;
        }
        low = std::min(low, value);
        high = std::max(high, value);
    }
    flush();
}

float legend_width(const Plot &plot) {
    float width = 0.0F;
    for (const PlotLine &line : plot.lines) {
        width += ImGui::CalcTextSize(line.label).x + 2.3F * ImGui::GetFontSize();
    }
    return width;
}

void draw_legend(ImDrawList &list, const Plot &plot, ImVec2 right_end) {
    const float font = ImGui::GetFontSize();
    float x = right_end.x;
    for (std::size_t i = plot.lines.size(); i-- > 0;) {
        const PlotLine &line = plot.lines[i];
        x -= ImGui::CalcTextSize(line.label).x;
        list.AddText({x, right_end.y}, packed(kInk), line.label);
        x -= 1.5F * font;
        const float y = right_end.y + 0.5F * font;
        list.AddLine({x, y}, {x + 1.1F * font, y}, packed(line.colour), 3.0F);
        x -= 0.8F * font;
    }
}

void show_values_under_mouse(const Plot &plot, const PlotFrame &frame, std::size_t first) {
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    if (!ImGui::IsItemHovered() || mouse.x < frame.lower.x || mouse.x > frame.upper.x ||
        plot.samples == first) {
        return;
    }
    const double share = (mouse.x - frame.lower.x) / (frame.upper.x - frame.lower.x);
    const double time_s = frame.first_s + share * (frame.last_s - frame.first_s);
    const std::size_t at = std::min(first_visible(plot, time_s), plot.samples - 1);
    ImGui::BeginTooltip();
    ImGui::Text("t = %.3f s", plot.time_s(at));
    for (const PlotLine &line : plot.lines) {
        const double value = line.value(at);
        const ImVec4 colour(line.colour.x, line.colour.y, line.colour.z, 1.0F);
        if (std::isnan(value)) {
            ImGui::TextColored(colour, "%s: –", line.label);
        } else {
            ImGui::TextColored(colour, "%s: %.3g", line.label, value);
        }
    }
    ImGui::EndTooltip();
}

} // namespace

void draw_plot(const Plot &plot, ImVec2 size) {
    const float font = ImGui::GetFontSize();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ImDrawList &list = *ImGui::GetWindowDrawList();
    ImGui::InvisibleButton(plot.title, size);

    PlotFrame frame;
    frame.lower = {corner.x + 2.6F * font, corner.y + size.y - 1.3F * font};
    frame.upper = {corner.x + size.x - 0.5F * font, corner.y + 1.6F * font};
    frame.last_s = plot.samples > 0 ? plot.time_s(plot.samples - 1) : 0.0;
    frame.first_s = frame.last_s - plot.span_s;
    const std::size_t first = first_visible(plot, frame.first_s);
    frame.top = std::min(round_up(std::max(plot.min_top, max_value(plot, first))), plot.max_top);

    list.AddText(corner, packed(kInk), plot.title);
    // Beside the title if there is room, else below it.
    const bool beside = ImGui::CalcTextSize(plot.title).x + legend_width(plot) < size.x - font;
    const float legend_y = beside ? corner.y : corner.y + 1.2F * font;
    draw_legend(list, plot, {corner.x + size.x - 0.5F * font, legend_y});
    frame.upper.y += beside ? 0.0F : 1.2F * font;
    list.PushClipRect(corner, {corner.x + size.x, corner.y + size.y}, true);
    draw_axes(list, plot, frame);
    draw_levels(list, plot, frame);
    list.PushClipRect({frame.lower.x, frame.upper.y - 1.0F}, {frame.upper.x, frame.lower.y + 1.0F},
                      true);
    for (const PlotLine &line : plot.lines) {
        draw_line(list, plot, line, frame, first);
    }
    list.PopClipRect();
    list.PopClipRect();
    show_values_under_mouse(plot, frame, first);
}

} // namespace springdrive::app

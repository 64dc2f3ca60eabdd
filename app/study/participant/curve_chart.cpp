#include "app/study/participant/curve_chart.h"

#include "app/study/participant/participant_palette.h"
#include "base/assertions.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace springdrive::app::study_screen {

namespace {

constexpr float kMaxDot = 1.0F / 15.0F; ///< radius, of the plot's height
constexpr double kAxisMargin = 1.12;    ///< of the axis beyond the levels, a factor
constexpr std::array<double, 5> kNamedShares{0.0, 0.25, 0.5, 0.75, 1.0};
constexpr ImU32 kBand = (palette::kAccent & ~IM_COL32_A_MASK) | 41U << IM_COL32_A_SHIFT;
constexpr ImU32 kDot = (palette::kInk & ~IM_COL32_A_MASK) | 191U << IM_COL32_A_SHIFT;
constexpr ImU32 kDotRim = IM_COL32(27, 29, 33, 255); // the ground

std::string percent(double share) { return fmt::format("{:.0f} %", 100.0 * share); }

/// Of the course, which is not empty; between its points.
double share_at(const std::vector<OwnCurve::Point> &course, double level) {
    const auto above = std::ranges::lower_bound(course, level, {}, &OwnCurve::Point::level);
    if (above == course.begin() || above == course.end()) {
        return (above == course.begin() ? course.front() : course.back()).right_share;
    }
    const OwnCurve::Point &below = *(above - 1);
    return std::lerp(below.right_share, above->right_share,
                     (level - below.level) / (above->level - below.level));
}

} // namespace

float CurveChart::x_px(const OwnCurve &curve, double level) const {
    const double lowest = curve.lowest_level / kAxisMargin;
    const double part =
        std::log(level / lowest) / std::log(curve.highest_level * kAxisMargin / lowest);
    return plot.corner.x + static_cast<float>(part) * plot.size.x;
}

float CurveChart::y_px(double right_share) const {
    return plot.corner.y + static_cast<float>(1.0 - right_share) * plot.size.y;
}

float dot_radius_px(int trials, float height_px) {
    const float share = std::min(1.0F, static_cast<float>(trials) / kFullTrials);
    return kMaxDot * height_px * std::sqrt(share);
}

/// The shares' label is above them, flush left.
CurveChart arranged(const OwnCurve &curve, const Rectangle &box, const ImFont &font,
                    float text_px) {
    SPRINGDRIVE_ASSERT(box.size.x > 0.0F && box.size.y > 0.0F && curve.lowest_level > 0.0 &&
                       curve.lowest_level < curve.highest_level);
    const auto text = [&](const std::string &words) {
        return wrapped(words, font, text_px, 2.0F * box.size.x);
    };
    CurveChart chart;
    const auto add = [&](TextLines label, float x, float y) {
        label.box.corner = {std::floor(x), std::floor(y)};
        chart.labels.push_back(std::move(label));
    };
    const float gap = std::floor(0.35F * text_px);
    const float wide = text(percent(1.0)).box.size.x + gap;
    chart.line_px = std::max(1.0F, std::round(box.size.y / 260.0F));
    chart.plot = {{box.corner.x + wide, box.corner.y + text_px + 2.0F * gap},
                  {box.size.x - wide - text_px, box.size.y - 3.0F * text_px - 4.0F * gap}};
    const Rectangle &plot = chart.plot;
    for (const double share : kNamedShares) {
        TextLines label = text(percent(share));
        const float left = plot.corner.x - gap - label.box.size.x;
        add(std::move(label), left, chart.y_px(share) - 0.5F * text_px);
    }
    add(text(curve.share_label), box.corner.x, box.corner.y);
    for (const double level : curve.ticks) {
        TextLines label = text(fmt::format("{:g}", level));
        const float left = chart.x_px(curve, level) - 0.5F * label.box.size.x;
        add(std::move(label), left, plot.corner.y + plot.size.y + gap);
    }
    TextLines label = text(curve.level_label);
    const float left = plot.corner.x + 0.5F * (plot.size.x - label.box.size.x);
    add(std::move(label), left, box.corner.y + box.size.y - text_px);
    return chart;
}

void draw_curve(const CurveChart &chart, const OwnCurve &curve, ImDrawList &list) {
    const Rectangle &plot = chart.plot;
    const float line = chart.line_px;
    const float right = plot.corner.x + plot.size.x;
    const float bottom = chart.y_px(0.0);
    for (const double share : kNamedShares) {
        const float y = chart.y_px(share);
        list.AddLine({plot.corner.x, y}, {right, y},
                     share == 0.0 ? palette::kDimInk : palette::kTrough, line);
    }
    const float chance_y = chart.y_px(curve.guess);
    for (float x = plot.corner.x; x < right; x += 8.0F * line) { // dashes
        list.AddLine({x, chance_y}, {std::min(x + 4.0F * line, right), chance_y},
                     palette::kPlateRim, line);
    }
    for (const double level : curve.ticks) {
        const float x = chart.x_px(curve, level);
        list.AddLine({x, bottom}, {x, bottom + 4.0F * line}, palette::kDimInk, line);
    }
    list.PushClipRect(plot.corner, {right, bottom}, true); // the course may be longer
    const ImDrawListFlags flags = list.Flags;
    list.Flags &= ~ImDrawListFlags_AntiAliasedFill; // or seams would be seen in the band
    std::vector<ImVec2> course;
    for (std::size_t i = 0; i < curve.course.size(); ++i) {
        const OwnCurve::Point &point = curve.course[i];
        const float x = chart.x_px(curve, point.level);
        course.emplace_back(x, chart.y_px(point.right_share));
        if (i > 0) {
            const OwnCurve::Point &before = curve.course[i - 1];
            const float x_before = chart.x_px(curve, before.level);
            list.AddQuadFilled({x_before, chart.y_px(before.low)}, {x, chart.y_px(point.low)},
                               {x, chart.y_px(point.high)}, {x_before, chart.y_px(before.high)},
                               kBand);
        }
    }
    list.Flags = flags;
    list.AddPolyline(course.data(), static_cast<int>(course.size()), palette::kAccent, 0,
                     2.0F * line);
    list.PopClipRect();
    if (curve.threshold && !course.empty()) { // down from the function to its interval
        const auto x_of = [&](double level) {
            return std::clamp(chart.x_px(curve, level), plot.corner.x, right);
        };
        const float x = x_of(curve.threshold->level);
        list.AddLine({x, chart.y_px(share_at(curve.course, curve.threshold->level))}, {x, bottom},
                     palette::kInk, line);
        list.AddLine({x_of(curve.threshold->low), bottom}, {x_of(curve.threshold->high), bottom},
                     palette::kInk, 4.0F * line);
        list.AddCircleFilled({x, bottom}, 5.0F * line, palette::kInk);
    }
    for (const OwnCurve::Dot &dot : curve.dots) {
        const ImVec2 place{chart.x_px(curve, dot.level), chart.y_px(dot.right_share)};
        const float radius = dot_radius_px(dot.trials, plot.size.y);
        list.AddCircleFilled(place, radius, kDot);
        list.AddCircle(place, radius, kDotRim, 0, line);
    }
}

} // namespace springdrive::app::study_screen

#include "app/study/participant/curve_chart.h"

#include "app/study/participant/participant_palette.h"
#include "base/assertions.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace springdrive::app::study_screen {

namespace {

constexpr double kLargestDot = 1.0 / 15.0; ///< radius, of the plot's height
constexpr double kAxisMargin = 1.12;       ///< of the axis beyond the levels, a factor
constexpr std::array<double, 5> kNamedShares{0.0, 0.25, 0.5, 0.75, 1.0};

glm::vec4 faint(glm::vec4 colour, float alpha) {
    colour.a = alpha;
    return colour;
}

Plate chart_bar(double left, double top, double width, double height, const glm::vec4 &colour) {
    return {{static_cast<float>(left), static_cast<float>(top)},
            {static_cast<float>(width), static_cast<float>(height)},
            colour};
}

Plate chart_disc(double x, double y, double radius, const glm::vec4 &colour, double border = 0.0) {
    Plate plate = chart_bar(x - radius, y - radius, 2.0 * radius, 2.0 * radius, colour);
    plate.radius_px = static_cast<float>(radius);
    plate.border_px = static_cast<float>(border);
    return plate;
}

/// Between the points of the course; nothing outside.
OwnCurve::Point course_at(const std::vector<OwnCurve::Point> &course, double level) {
    const auto above = std::ranges::upper_bound(course, level, {}, &OwnCurve::Point::level);
    if (above == course.begin()) {
        return course.front();
    }
    if (above == course.end()) {
        return course.back();
    }
    const OwnCurve::Point &below = *(above - 1);
    const double part = (level - below.level) / (above->level - below.level);
    return {level, std::lerp(below.right_share, above->right_share, part),
            std::lerp(below.low, above->low, part), std::lerp(below.high, above->high, part)};
}

class ChartMaker {
public:
    ChartMaker(const OwnCurve &curve, const PixelBox &box, double text_px, const Typeface &typeface)
        : curve_(curve), box_(box), text_px_(text_px), typeface_(typeface),
          thin_px_(std::max(1.0, std::round(box.height / 260.0))),
          gap_px_(static_cast<int>(0.35 * text_px)) {}

    CurveChart made() {
        place_plot();
        add_shares();
        add_ticks();
        add_course();
        add_threshold();
        add_dots();
        return std::move(chart_);
    }

private:
    [[nodiscard]] PlacedText text(const std::string &words) const {
        TextLines lines = wrapped(words, typeface_, text_px_, 2 * box_.width);
        return {{0, 0, lines.width_px, lines.height_px()}, std::move(lines)};
    }

    void add(PlacedText placed, int x, int y) {
        placed.box.x = x;
        placed.box.y = y;
        chart_.texts.push_back(std::move(placed));
    }

    static std::string percent(double share) { return fmt::format("{:.0f} %", 100.0 * share); }

    /// Room for the labels around it. The shares' label is above them, flush left.
    void place_plot() {
        const int wide = text(percent(1.0)).box.width + gap_px_;
        const int line = text("0").box.height;
        chart_.plot = {box_.x + wide, box_.y + line + 2 * gap_px_, box_.width - wide - line,
                       box_.height - 3 * line - 4 * gap_px_};
    }

    void add_shares() {
        const PixelBox &plot = chart_.plot;
        for (const double share : kNamedShares) {
            const double y = chart_.y_px(share);
            const bool is_axis = share == 0.0;
            chart_.plates.push_back(chart_bar(plot.x, y - 0.5 * thin_px_, plot.width, thin_px_,
                                              is_axis ? palette::kDimInk : palette::kTrough));
            PlacedText label = text(percent(share));
            const int left = plot.x - gap_px_ - label.box.width;
            const int top = static_cast<int>(y) - label.box.height / 2;
            add(std::move(label), left, top);
        }
        add(text(curve_.share_label), box_.x, box_.y);
        const double chance_y = chart_.y_px(curve_.guess);
        const double dash_px = 8.0 * thin_px_; // with the gap after it
        for (int i = 0; i * dash_px < plot.width; ++i) {
            chart_.plates.push_back(chart_bar(plot.x + i * dash_px, chance_y - 0.5 * thin_px_,
                                              4.0 * thin_px_, thin_px_, palette::kPlateRim));
        }
    }

    void add_ticks() {
        const PixelBox &plot = chart_.plot;
        const int bottom = plot.y + plot.height;
        for (const double level : curve_.ticks) {
            const double x = chart_.x_px(curve_, level);
            chart_.plates.push_back(
                chart_bar(x - 0.5 * thin_px_, bottom, thin_px_, gap_px_, palette::kDimInk));
            PlacedText label = text(fmt::format("{:g}", level));
            const int left = static_cast<int>(x) - label.box.width / 2;
            add(std::move(label), left, bottom + gap_px_);
        }
        PlacedText label = text(curve_.level_label);
        const int left = plot.x + (plot.width - label.box.width) / 2;
        const int top = box_.y + box_.height - label.box.height;
        add(std::move(label), left, top);
    }

    [[nodiscard]] double level_at_px(double x) const {
        const double part = (x - chart_.plot.x) / chart_.plot.width;
        return std::exp(std::lerp(std::log(curve_.lowest_level / kAxisMargin),
                                  std::log(curve_.highest_level * kAxisMargin), part));
    }

    /// The band column by column, and the function as discs close together.
    void add_course() {
        if (curve_.course.empty()) {
            return;
        }
        const PixelBox &plot = chart_.plot;
        for (int x = plot.x; x < plot.x + plot.width; ++x) {
            const OwnCurve::Point at = course_at(curve_.course, level_at_px(x + 0.5));
            const double top = chart_.y_px(at.high);
            chart_.plates.push_back(
                chart_bar(x, top, 1.0, chart_.y_px(at.low) - top, faint(palette::kAccent, 0.16F)));
        }
        for (int half_px = 0; half_px <= 2 * plot.width; ++half_px) {
            const double x = plot.x + 0.5 * half_px;
            const OwnCurve::Point at = course_at(curve_.course, level_at_px(x));
            chart_.plates.push_back(
                chart_disc(x, chart_.y_px(at.right_share), thin_px_, palette::kAccent));
        }
    }

    /// Down from the function to the axis, where the interval is.
    void add_threshold() {
        if (!curve_.threshold || curve_.course.empty()) {
            return;
        }
        const OwnCurve::Threshold &threshold = *curve_.threshold;
        const auto x_of = [this](double level) {
            return std::clamp(chart_.x_px(curve_, level), static_cast<double>(chart_.plot.x),
                              static_cast<double>(chart_.plot.x + chart_.plot.width));
        };
        const double x = x_of(threshold.level);
        const double y = chart_.y_px(course_at(curve_.course, threshold.level).right_share);
        const double bottom = chart_.y_px(0.0);
        chart_.plates.push_back(
            chart_bar(x - 0.5 * thin_px_, y, thin_px_, bottom - y, palette::kInk));
        const double low = x_of(threshold.low);
        Plate interval = chart_bar(low, bottom - 2.0 * thin_px_, x_of(threshold.high) - low,
                                   4.0 * thin_px_, palette::kInk);
        interval.radius_px = static_cast<float>(2.0 * thin_px_);
        chart_.plates.push_back(interval);
        chart_.plates.push_back(chart_disc(x, bottom, 5.0 * thin_px_, palette::kInk));
    }

    void add_dots() {
        for (const OwnCurve::Dot &dot : curve_.dots) {
            const double x = chart_.x_px(curve_, dot.level);
            const double y = chart_.y_px(dot.right_share);
            const double radius = dot_radius_px(dot.trials, chart_.plot.height);
            chart_.plates.push_back(chart_disc(x, y, radius, faint(palette::kInk, 0.75F)));
            chart_.plates.push_back(
                chart_disc(x, y, radius, glm::vec4(palette::kGround, 1.0F), thin_px_));
        }
    }

    const OwnCurve &curve_;
    PixelBox box_;
    double text_px_;
    const Typeface &typeface_;
    double thin_px_; ///< of lines
    int gap_px_;
    CurveChart chart_;
};

} // namespace

double CurveChart::x_px(const OwnCurve &curve, double level) const {
    const double lowest = curve.lowest_level / kAxisMargin;
    const double part =
        std::log(level / lowest) / std::log(curve.highest_level * kAxisMargin / lowest);
    return plot.x + part * plot.width;
}

double CurveChart::y_px(double right_share) const {
    return plot.y + (1.0 - right_share) * plot.height;
}

double dot_radius_px(int trials, double height_px) {
    const double share = std::min(1.0, static_cast<double>(trials) / kFullTrials);
    return kLargestDot * height_px * std::sqrt(share);
}

CurveChart arranged(const OwnCurve &curve, const PixelBox &box, double text_px,
                    const Typeface &typeface) {
    SPRINGDRIVE_ASSERT(!box.is_empty() && curve.lowest_level > 0.0 &&
                       curve.lowest_level < curve.highest_level);
    return ChartMaker(curve, box, text_px, typeface).made();
}

} // namespace springdrive::app::study_screen

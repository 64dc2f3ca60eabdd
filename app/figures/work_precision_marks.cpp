#include "app/figures/work_precision_marks.h"

#include "app/figures/name_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string_view>
#include <vector>

namespace springdrive::app {

namespace {

/// A logarithmic axis around positive numbers, with room beyond the outermost.
class LogRange {
public:
    void include(double number) {
        if (number > 0.0 && std::isfinite(number)) {
            least_ = std::min(least_, std::log10(number));
            greatest_ = std::max(greatest_, std::log10(number));
        }
    }

    /// @param room below, as a share of what the numbers take; at least a fifth of a decade
    [[nodiscard]] double low(double room) const {
        return std::isfinite(least_) ? std::pow(10.0, least_ - room_decades(room)) : 0.1;
    }
    [[nodiscard]] double high(double room) const {
        return std::isfinite(least_) ? std::pow(10.0, greatest_ + room_decades(room)) : 10.0;
    }

private:
    [[nodiscard]] double room_decades(double room) const {
        return std::max(0.2, room * (greatest_ - least_));
    }

    double least_ = std::numeric_limits<double>::infinity();
    double greatest_ = -std::numeric_limits<double>::infinity();
};

/// An error so many decades below the next is what arithmetic rounds off, not one of the method.
constexpr double kRoundOffGap_decades = 6.0;

/// The greatest error that is round-off; 0 where none is, but for errors of 0.
double round_off_of(const rig::WorkPrecisionChart &chart) {
    std::vector<double> decades;
    for (const rig::WorkPoint &point : chart.points) {
        if (point.error > 0.0 && std::isfinite(point.error)) {
            decades.push_back(std::log10(point.error));
        }
    }
    std::ranges::sort(decades);
    for (std::size_t i = decades.size(); i-- > 1;) {
        if (decades[i] - decades[i - 1] > kRoundOffGap_decades) {
            return 1.01 * std::pow(10.0, decades[i - 1]); // as rounded in the file
        }
    }
    return 0.0;
}

/// What both axes hold.
struct Frame {
    double cost_low_ns;
    double cost_high_ns;
    double error_low;
    double error_high;
    double round_off;     ///< the greatest error that stands at `error_of_zero`
    double error_of_zero; ///< where errors of 0 and round-off stand; 0 if there are none
    double error_of_none; ///< where failures without an error to tell stand

    /// Where a point stands, in shares of the frame.
    [[nodiscard]] Spot spot(double cost_ns, double error) const {
        const double shown = !std::isfinite(error) ? error_of_none
                             : error <= round_off  ? error_of_zero
                                                   : error;
        return {std::log10(cost_ns / cost_low_ns) / std::log10(cost_high_ns / cost_low_ns),
                std::log10(shown / error_low) / std::log10(error_high / error_low)};
    }
};

Frame frame_of(const rig::WorkPrecisionChart &chart) {
    LogRange cost_ns;
    LogRange error;
    const double round_off = round_off_of(chart);
    bool has_zero = false;
    bool has_none = false;
    for (const rig::WorkPoint &point : chart.points) {
        cost_ns.include(point.cost.least_ns);
        cost_ns.include(point.cost.greatest_ns);
        has_zero |= point.error <= round_off;
        has_none |= !std::isfinite(point.error);
        if (point.error > round_off) {
            error.include(point.error);
        }
    }
    Frame frame{};
    frame.cost_low_ns = cost_ns.low(0.05);
    frame.cost_high_ns = cost_ns.high(0.15);
    frame.error_low = error.low(0.1);
    frame.error_high = error.high(0.1);
    frame.round_off = round_off;
    if (has_zero) {
        frame.error_of_zero = 0.1 * frame.error_low;
        frame.error_low *= 0.05;
    }
    if (has_none) { // above all others, with room for its name
        const double room = std::pow(frame.error_high / frame.error_low, 0.08);
        frame.error_of_none = frame.error_high;
        frame.error_high *= room;
    }
    return frame;
}

/// The methods' names, each once, in the order in which they come.
std::vector<std::string> methods_of(const rig::WorkPrecisionChart &chart) {
    std::vector<std::string> methods;
    for (const rig::WorkPoint &point : chart.points) {
        if (std::ranges::find(methods, point.method) == methods.end()) {
            methods.push_back(point.method);
        }
    }
    return methods;
}

/// As gnuplot's word() takes them apart.
std::string words_of(const std::vector<std::string> &methods) {
    std::string words;
    for (const std::string &method : methods) {
        words += '"' + method + "\" ";
    }
    return words;
}

/// For each row the number of its method, from 1.
std::string method_of_rows(const rig::WorkPrecisionChart &chart,
                           const std::vector<std::string> &methods) {
    std::string numbers;
    for (const rig::WorkPoint &point : chart.points) {
        const auto found = std::ranges::find(methods, point.method);
        numbers += std::to_string(found - methods.begin() + 1) + ' ';
    }
    return numbers;
}

/// All that names had better not cross: the lines between points, and the bars of their times.
std::vector<Stroke> strokes_of(const rig::WorkPrecisionChart &chart, const Frame &frame) {
    std::vector<Stroke> strokes;
    const rig::WorkPoint *before = nullptr; // of the same line
    for (const rig::WorkPoint &point : chart.points) {
        if (!point.stable) {
            continue;
        }
        const Spot here = frame.spot(point.cost.least_ns, point.error);
        strokes.push_back({here, frame.spot(point.cost.greatest_ns, point.error)});
        if (before != nullptr && before->method == point.method) {
            strokes.push_back({frame.spot(before->cost.least_ns, before->error), here});
        }
        before = &point;
    }
    return strokes;
}

std::size_t letters_in(const std::string &text) {
    return static_cast<std::size_t>(std::ranges::count_if(
        text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

/// For each corner, in their order, the rows whose names stand there, as numbers between spaces:
/// the first and the last point of each method, but for those that have no room.
std::array<std::string, 4> named_rows(const rig::WorkPrecisionChart &chart, const Frame &frame) {
    const auto &points = chart.points;
    std::vector<std::size_t> rows;
    std::vector<PointName> names;
    std::vector<Spot> spots;
    for (std::size_t i = 0; i < points.size(); ++i) {
        spots.push_back(frame.spot(points[i].cost.least_ns, points[i].error));
        const bool is_first = i == 0 || points[i - 1].method != points[i].method;
        const bool is_last = i + 1 == points.size() || points[i + 1].method != points[i].method;
        if (is_first || is_last) {
            rows.push_back(i);
            names.push_back({spots.back(), letters_in(points[i].setting)});
        }
    }
    const auto corners = name_corners(names, spots, strokes_of(chart, frame));
    std::array<std::string, 4> text{" ", " ", " ", " "};
    for (std::size_t i = 0; i < rows.size(); ++i) {
        if (corners[i]) {
            text[static_cast<std::size_t>(*corners[i])] += std::to_string(rows[i]) + ' ';
        }
    }
    return text;
}

} // namespace

ChartMarks work_precision_marks(const rig::WorkPrecisionChart &chart, const std::string &footnote) {
    const Frame frame = frame_of(chart);
    const std::vector<std::string> methods = methods_of(chart);
    ChartMarks marks;
    marks.add("heading", chart.title);
    marks.add("footnote", footnote);
    marks.add("cost_label", chart.cost_label);
    marks.add("error_label", chart.error_label);
    marks.add("methods", words_of(methods));
    marks.add("method_of_rows", method_of_rows(chart, methods));
    constexpr std::array<std::string_view, 4> kCorners{"right_above", "right_below", "left_above",
                                                       "left_below"};
    const std::array<std::string, 4> rows = named_rows(chart, frame);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        marks.add("named_" + std::string(kCorners[i]), rows[i]);
    }
    const bool fails =
        std::ranges::any_of(chart.points, std::logical_not<>(), &rig::WorkPoint::stable);
    marks.add("has_failures", fails ? 1.0 : 0.0);
    marks.add("cost_low_s", 1e-9 * frame.cost_low_ns);
    marks.add("cost_high_s", 1e-9 * frame.cost_high_ns);
    marks.add("error_low", frame.error_low);
    marks.add("error_high", frame.error_high);
    marks.add("round_off", frame.round_off);
    marks.add("error_of_zero", frame.error_of_zero);
    marks.add("error_of_none", frame.error_of_none);
    return marks;
}

} // namespace springdrive::app

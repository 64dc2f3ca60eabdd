#include "app/figures/speed_accuracy_marks.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace springdrive::app {

namespace {

/// A logarithmic axis over positive numbers, with a margin beyond the outermost.
class LogRange {
public:
    void include(double number) {
        if (number > 0.0 && std::isfinite(number)) {
            minimum_ = std::min(minimum_, std::log10(number));
            maximum_ = std::max(maximum_, std::log10(number));
        }
    }

    /// @param room below, relative to the range of the numbers; at least a fifth of a decade
    [[nodiscard]] double low(double room) const {
        return std::isfinite(minimum_) ? std::pow(10.0, minimum_ - room_decades(room)) : 0.1;
    }
    [[nodiscard]] double high(double room) const {
        return std::isfinite(minimum_) ? std::pow(10.0, maximum_ + room_decades(room)) : 10.0;
    }

private:
    [[nodiscard]] double room_decades(double room) const {
        return std::max(0.2, room * (maximum_ - minimum_));
    }

    double minimum_ = std::numeric_limits<double>::infinity();
    double maximum_ = -std::numeric_limits<double>::infinity();
};

/// An error this many decades below the next is round-off, not an error of the method.
constexpr double kRoundOffGap_decades = 6.0;

/// The largest error that is round-off; 0 if there are none except errors of 0.
double round_off_of(const charts::SpeedAccuracyChart &chart) {
    std::vector<double> decades;
    for (const charts::ChartPoint &point : chart.points) {
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

/// The ranges of both axes.
struct Frame {
    double cost_low_ns;
    double cost_high_ns;
    double error_low;
    double error_high;
    double round_off;     ///< the largest error that is drawn at `error_of_zero`
    double error_of_zero; ///< where errors of 0 and round-off are drawn; 0 if there are none
    double error_of_none; ///< where failures without a measured error are drawn
};

Frame frame_of(const charts::SpeedAccuracyChart &chart) {
    LogRange cost_ns;
    LogRange error;
    const double round_off = round_off_of(chart);
    bool has_zero = false;
    bool has_none = false;
    for (const charts::ChartPoint &point : chart.points) {
        cost_ns.include(point.cost.min_ns);
        cost_ns.include(point.cost.max_ns);
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
    if (has_none) { // above all others, with room for its mark
        const double room = std::pow(frame.error_high / frame.error_low, 0.08);
        frame.error_of_none = frame.error_high;
        frame.error_high *= room;
    }
    return frame;
}

/// The methods' names, each once, in order of appearance.
std::vector<std::string> methods_of(const charts::SpeedAccuracyChart &chart) {
    std::vector<std::string> methods;
    for (const charts::ChartPoint &point : chart.points) {
        if (std::ranges::find(methods, point.method) == methods.end()) {
            methods.push_back(point.method);
        }
    }
    return methods;
}

/// "1000 … 0.98 µs": both settings, with a unit that they share only once.
std::string range_text(const std::string &first, const std::string &last) {
    if (first == last) {
        return first;
    }
    const std::size_t end = first.rfind(' ');
    const bool is_common = end != std::string::npos && last.ends_with(first.substr(end));
    return (is_common ? first.substr(0, end) : first) + " … " + last;
}

/// Each method and its settings, in the format of gnuplot's word().
std::string legend_of(const charts::SpeedAccuracyChart &chart,
                      const std::vector<std::string> &methods) {
    std::string legend;
    for (const std::string &method : methods) {
        const auto first = std::ranges::find(chart.points, method, &charts::ChartPoint::method);
        const auto last = std::find_if(chart.points.rbegin(), chart.points.rend(),
                                       [&](const auto &point) { return point.method == method; });
        legend += '"' + method + ": " + range_text(first->setting, last->setting) + "\" ";
    }
    return legend;
}

/// For each row the number of its method, from 1.
std::string method_of_rows(const charts::SpeedAccuracyChart &chart,
                           const std::vector<std::string> &methods) {
    std::string numbers;
    for (const charts::ChartPoint &point : chart.points) {
        const auto found = std::ranges::find(methods, point.method);
        numbers += std::to_string(found - methods.begin() + 1) + ' ';
    }
    return numbers;
}

} // namespace

ChartMarks speed_accuracy_marks(const charts::SpeedAccuracyChart &chart,
                                const std::string &footnote) {
    const Frame frame = frame_of(chart);
    const std::vector<std::string> methods = methods_of(chart);
    ChartMarks marks;
    marks.add("heading", chart.title);
    marks.add("footnote", footnote);
    marks.add("cost_label", chart.cost_label);
    marks.add("error_label", chart.error_label);
    marks.add("legend", legend_of(chart, methods));
    marks.add("method_of_rows", method_of_rows(chart, methods));
    const bool fails =
        std::ranges::any_of(chart.points, std::logical_not<>(), &charts::ChartPoint::stable);
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

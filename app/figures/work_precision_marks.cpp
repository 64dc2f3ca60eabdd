#include "app/figures/work_precision_marks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace springdrive {

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

/// What both axes hold. Names stand to the right of their points.
struct Frame {
    double cost_low_ns;
    double cost_high_ns;
    double error_low;
    double error_high;
    double error_of_zero; ///< where an error of 0 stands; 0 if there is none
};

Frame frame_of(const WorkPrecisionChart &chart) {
    LogRange cost_ns;
    LogRange error;
    bool has_zero = false;
    for (const WorkPoint &point : chart.points) {
        cost_ns.include(point.cost.least_ns);
        cost_ns.include(point.cost.greatest_ns);
        error.include(point.error);
        has_zero |= point.error == 0.0;
    }
    Frame frame{cost_ns.low(0.1), cost_ns.high(0.2), error.low(0.1), error.high(0.15), 0.0};
    if (has_zero) {
        frame.error_of_zero = 0.1 * frame.error_low;
        frame.error_low *= 0.05;
    }
    return frame;
}

/// The methods' names, each once, in the order in which they come.
std::vector<std::string> methods_of(const WorkPrecisionChart &chart) {
    std::vector<std::string> methods;
    for (const WorkPoint &point : chart.points) {
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
std::string method_of_rows(const WorkPrecisionChart &chart,
                           const std::vector<std::string> &methods) {
    std::string numbers;
    for (const WorkPoint &point : chart.points) {
        const auto found = std::ranges::find(methods, point.method);
        numbers += std::to_string(found - methods.begin() + 1) + ' ';
    }
    return numbers;
}

/// The first and the last point of each method, as numbers of rows between spaces, but for those
/// whose names would cover another.
std::string named_rows(const WorkPrecisionChart &chart, const Frame &frame) {
    const double width = std::log10(frame.cost_high_ns / frame.cost_low_ns);
    const double height = std::log10(frame.error_high / frame.error_low);
    const auto cover = [&](const WorkPoint &a, const WorkPoint &b) {
        const double dx = std::log10(a.cost.least_ns / b.cost.least_ns) / width;
        const double dy = std::log10(a.error / b.error) / height;
        return std::abs(dx) < 0.16 && !(std::abs(dy) >= 0.03); // both may be 0
    };
    std::string rows = " ";
    std::vector<std::size_t> named;
    const auto &points = chart.points;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const bool is_first = i == 0 || points[i - 1].method != points[i].method;
        const bool is_last = i + 1 == points.size() || points[i + 1].method != points[i].method;
        const bool is_covered = std::ranges::any_of(
            named, [&](std::size_t other) { return cover(points[other], points[i]); });
        if ((is_first || is_last) && !is_covered) {
            named.push_back(i);
            rows += std::to_string(i) + ' ';
        }
    }
    return rows;
}

} // namespace

ChartMarks work_precision_marks(const WorkPrecisionChart &chart, const std::string &footnote) {
    const Frame frame = frame_of(chart);
    const std::vector<std::string> methods = methods_of(chart);
    ChartMarks marks;
    marks.add("heading", chart.title);
    marks.add("footnote", footnote);
    marks.add("cost_label", chart.cost_label);
    marks.add("error_label", chart.error_label);
    marks.add("methods", words_of(methods));
    marks.add("method_of_rows", method_of_rows(chart, methods));
    marks.add("named_rows", named_rows(chart, frame));
    marks.add("cost_low_s", 1e-9 * frame.cost_low_ns);
    marks.add("cost_high_s", 1e-9 * frame.cost_high_ns);
    marks.add("error_low", frame.error_low);
    marks.add("error_high", frame.error_high);
    marks.add("error_of_zero", frame.error_of_zero);
    return marks;
}

} // namespace springdrive

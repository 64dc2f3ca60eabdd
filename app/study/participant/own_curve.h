// A psychometric function, as it is shown to the one who gave the answers. Plain values: what a
// picture with a curve is drawn from.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {

struct OwnCurve {
    /// All answers at one level.
    struct Dot {
        double level = 0.0;
        double right_share = 0.0;
        int trials = 0;

        friend bool operator==(const Dot &, const Dot &) = default;
    };
    /// The fitted function at a level, with its 95 % band.
    struct Point {
        double level = 0.0;
        double right_share = 0.0;
        double low = 0.0;
        double high = 0.0;

        friend bool operator==(const Point &, const Point &) = default;
    };
    /// The level at the threshold, with its 95 % interval.
    struct Threshold {
        double level = 0.0;
        double low = 0.0;
        double high = 0.0;

        friend bool operator==(const Threshold &, const Threshold &) = default;
    };

    double lowest_level = 1.0; ///< that can be presented; > 0, as the axis is logarithmic
    double highest_level = 10.0;
    double guess = 0.5;        ///< share of right answers by chance
    std::vector<double> ticks; ///< levels that are named at the axis
    std::string level_label;
    std::string share_label;
    std::vector<Dot> dots;
    std::vector<Point> course; ///< by rising level; empty before there is a fit
    std::optional<Threshold> threshold;

    friend bool operator==(const OwnCurve &, const OwnCurve &) = default;
};

} // namespace springdrive::app::study_screen

#include "app/figures/name_places.h"

#include <algorithm>
#include <iterator>

namespace springdrive::app {

namespace {

// Of a frame of 760 by 410 pixels, in letters of 11.
constexpr double kLetterWidth = 0.0088;
constexpr double kLetterHeight = 0.034;
constexpr double kAside = 0.011; ///< from the middle of the point to the name's first letter
constexpr double kAbove = 0.026; ///< from there to the name's middle
constexpr double kMarkHalfWidth = 0.008;
constexpr double kMarkHalfHeight = 0.015;

constexpr std::ptrdiff_t kMostStrokes = 3; ///< through more of them a name cannot be read

struct Box {
    double left = 0.0;
    double right = 0.0;
    double low = 0.0;
    double high = 0.0;

    [[nodiscard]] bool meets(const Box &other) const {
        return left < other.right && other.left < right && low < other.high && other.low < high;
    }
    [[nodiscard]] bool holds(const Spot &spot) const {
        return spot.x > left && spot.x < right && spot.y > low && spot.y < high;
    }
};

Box box_of(const PointName &name, NameCorner corner) {
    const bool right = corner == NameCorner::right_above || corner == NameCorner::right_below;
    const bool above = corner == NameCorner::right_above || corner == NameCorner::left_above;
    const double width = kLetterWidth * static_cast<double>(name.letters);
    const double left = right ? name.point.x + kAside : name.point.x - kAside - width;
    const double middle = name.point.y + (above ? kAbove : -kAbove);
    return {left, left + width, middle - 0.5 * kLetterHeight, middle + 0.5 * kLetterHeight};
}

Box mark_of(const Spot &point) {
    return {point.x - kMarkHalfWidth, point.x + kMarkHalfWidth, point.y - kMarkHalfHeight,
            point.y + kMarkHalfHeight};
}

bool is_crossed_by(const Box &box, const Stroke &stroke) {
    constexpr int kSteps = 100; // each far below the height of a letter
    for (int i = 0; i <= kSteps; ++i) {
        const double share = static_cast<double>(i) / kSteps;
        if (box.holds({stroke.from.x + share * (stroke.to.x - stroke.from.x),
                       stroke.from.y + share * (stroke.to.y - stroke.from.y)})) {
            return true;
        }
    }
    return false;
}

bool is_within_frame(const Box &box) {
    return box.left > 0.0 && box.right < 1.0 && box.low > 0.0 && box.high < 1.0;
}

} // namespace

std::vector<std::optional<NameCorner>> name_corners(const std::vector<PointName> &names,
                                                    const std::vector<Spot> &points,
                                                    const std::vector<Stroke> &strokes) {
    std::vector<Box> taken;
    std::transform(points.begin(), points.end(), std::back_inserter(taken), mark_of);
    std::vector<std::optional<NameCorner>> corners;
    for (const PointName &name : names) {
        std::optional<NameCorner> best;
        std::ptrdiff_t fewest = 0;
        for (const NameCorner corner : {NameCorner::right_above, NameCorner::right_below,
                                        NameCorner::left_above, NameCorner::left_below}) {
            const Box box = box_of(name, corner);
            if (!is_within_frame(box) ||
                std::any_of(taken.begin(), taken.end(),
                            [&](const Box &other) { return box.meets(other); })) {
                continue;
            }
            const std::ptrdiff_t crossed =
                std::count_if(strokes.begin(), strokes.end(),
                              [&](const Stroke &stroke) { return is_crossed_by(box, stroke); });
            if (crossed <= kMostStrokes && (!best || crossed < fewest)) {
                best = corner;
                fewest = crossed;
            }
        }
        if (best) {
            taken.push_back(box_of(name, *best));
        }
        corners.push_back(best);
    }
    return corners;
}

} // namespace springdrive::app

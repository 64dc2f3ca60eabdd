#include "engine/lab/rig/crossing_finder.h"

#include "engine/contact/mesh/facet.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace springdrive::rig {

namespace {

/// A motion no farther than this beside a triangle goes through it [m]: a hundredth of what the
/// proxy keeps, so that a gap between triangles that is too narrow for the proxy is none.
constexpr double kRim_m = 1e-10;

/// Round-off may shift a crossing by more, along a motion that is almost parallel to a triangle
/// with almost parallel edges; up to half of what the proxy keeps is then taken for a crossing.
constexpr double kMaxRim_m = 0.5 * contact::kClearance_m;

constexpr double kUnitRoundOff = 0.5 * std::numeric_limits<double>::epsilon();

/// By how far the computed crossing of a plane may be beside the true one [m].
///
/// A height n · (p − c) is the product of a difference (relative error u), a normal (cross product
/// of differences, 4 u / sine, and normalised, 3 u) and a sum of three products (3 u): at most
/// 11 u d / sine for a point at the distance d, here twice the largest of those that occur. The
/// share of the motion is a ratio of heights, hence the slope; the point of that share, and its
/// height beyond an edge, are rounded once more.
double round_off_of_crossing_m(const PlainTriangle &triangle, const Vector3 &from_m,
                               const Vector3 &to_m, double height_m) {
    const double way_m = (to_m - from_m).norm();
    const double farthest_m = (from_m - triangle.corners_m[0]).norm() + way_m;
    const double height_error_m = 11.0 * kUnitRoundOff * farthest_m / triangle.sine();
    const double largest_m = from_m.norm() + way_m;
    return 2.0 *
           (height_error_m * (1.0 + 2.0 * way_m / height_m) + 3.0 * kUnitRoundOff * largest_m);
}

/// Cells along the longest side of the box: 2 million in all at most.
constexpr double kMaxCells = 128.0;

} // namespace

bool goes_through(const PlainTriangle &triangle, const Vector3 &from_m, const Vector3 &to_m) {
    const double from_height_m = triangle.height_m(from_m);
    const double to_height_m = triangle.height_m(to_m);
    const bool goes_in = from_height_m >= 0.0 && to_height_m < 0.0;
    const bool comes_out = from_height_m <= 0.0 && to_height_m > 0.0;
    if (!goes_in && !(comes_out && triangle.two_sided)) {
        return false;
    }
    const double share = from_height_m / (from_height_m - to_height_m);
    const double beyond_m = triangle.beyond_m(from_m + share * (to_m - from_m));
    return beyond_m <= kRim_m ||
           (beyond_m <= kMaxRim_m &&
            beyond_m <= round_off_of_crossing_m(triangle, from_m, to_m,
                                                std::abs(from_height_m - to_height_m)));
}

CrossingFinder::CrossingFinder(std::span<const PlainTriangle> triangles) : triangles_(triangles) {
    double sizes_m = 0.0;
    for (const PlainTriangle &triangle : triangles) {
        box_.extend(triangle.bounds());
        sizes_m += triangle.bounds().diagonal().norm();
    }
    if (triangles.empty()) {
        return;
    }
    cell_m_ = std::max(sizes_m / static_cast<double>(triangles.size()),
                       box_.diagonal().maxCoeff() / kMaxCells);
    cells_ = (box_.diagonal() / cell_m_).array().floor().cast<int>() + 1;
    // How many come into each cell, where each begins, then who they are.
    first_.assign(static_cast<std::size_t>(cells_.prod()) + 1, 0);
    for (const PlainTriangle &triangle : triangles) {
        for_each_cell(triangle, [&](std::size_t cell) { ++first_[cell + 1]; });
    }
    for (std::size_t cell = 1; cell < first_.size(); ++cell) {
        first_[cell] += first_[cell - 1];
    }
    entries_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        for_each_cell(triangles[i], [&](std::size_t cell) {
            entries_[next[cell]++] = static_cast<std::uint32_t>(i);
        });
    }
}

CrossingFinder::Cell CrossingFinder::cell_of(const Vector3 &point_m) const {
    const Eigen::Array3d place = ((point_m - box_.min()) / cell_m_).array().floor();
    return place.max(0.0).min((cells_ - 1).cast<double>()).cast<int>();
}

std::size_t CrossingFinder::index(int x, int y, int z) const {
    const auto cell = [](int i) { return static_cast<std::size_t>(i); };
    return (cell(z) * cell(cells_.y()) + cell(y)) * cell(cells_.x()) + cell(x);
}

template <typename Visit>
void CrossingFinder::for_each_cell(const Eigen::AlignedBox3d &box, const Visit &visit) const {
    const Cell minimum = cell_of(box.min());
    const Cell maximum = cell_of(box.max());
    for (int z = minimum.z(); z <= maximum.z(); ++z) {
        for (int y = minimum.y(); y <= maximum.y(); ++y) {
            for (int x = minimum.x(); x <= maximum.x(); ++x) {
                visit(index(x, y, z));
            }
        }
    }
}

template <typename Visit>
void CrossingFinder::for_each_cell(const PlainTriangle &triangle, const Visit &visit) const {
    // A cell's corner is no farther than this from its middle; a little more for round-off.
    const double half_diagonal_m = 0.87 * cell_m_;
    const Cell minimum = cell_of(triangle.bounds().min());
    const Cell maximum = cell_of(triangle.bounds().max());
    for (int z = minimum.z(); z <= maximum.z(); ++z) {
        for (int y = minimum.y(); y <= maximum.y(); ++y) {
            for (int x = minimum.x(); x <= maximum.x(); ++x) {
                const Vector3 middle_m = box_.min() + cell_m_ * Vector3(x + 0.5, y + 0.5, z + 0.5);
                if (std::abs(triangle.height_m(middle_m)) <= half_diagonal_m) {
                    visit(index(x, y, z));
                }
            }
        }
    }
}

std::optional<std::size_t> CrossingFinder::crossed(const Vector3 &from_m,
                                                   const Vector3 &to_m) const {
    if (triangles_.empty()) {
        return std::nullopt;
    }
    // A long way in parts, each of which comes into few cells.
    const auto parts = static_cast<int>(std::ceil((to_m - from_m).norm() / cell_m_));
    for (int part = 0; part < parts; ++part) {
        Eigen::AlignedBox3d box(Vector3(from_m + (to_m - from_m) * part / parts));
        box.extend(Vector3(from_m + (to_m - from_m) * (part + 1) / parts));
        box.min().array() -= kMaxRim_m;
        box.max().array() += kMaxRim_m;
        if (!box.intersects(box_)) {
            continue;
        }
        std::optional<std::size_t> found;
        for_each_cell(box, [&](std::size_t cell) {
            for (std::uint32_t i = first_[cell]; i < first_[cell + 1] && !found; ++i) {
                if (goes_through(triangles_[entries_[i]], from_m, to_m)) {
                    found = entries_[i];
                }
            }
        });
        if (found) {
            return found;
        }
    }
    return std::nullopt;
}

} // namespace springdrive::rig

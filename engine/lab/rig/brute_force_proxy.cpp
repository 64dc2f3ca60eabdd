#include "engine/lab/rig/brute_force_proxy.h"

#include "engine/contact/mesh/facet.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace springdrive::rig {

namespace {

/// Which minimise cancellation.
std::array<Vector3, 2> two_shorter_edges(const std::array<Vector3, 3> &corners_m) {
    const std::array<Vector3, 3> edges{Vector3(corners_m[1] - corners_m[0]),
                                       Vector3(corners_m[2] - corners_m[1]),
                                       Vector3(corners_m[0] - corners_m[2])};
    const auto *const longest =
        std::ranges::max_element(edges, {}, [](const Vector3 &edge) { return edge.squaredNorm(); });
    const auto i = static_cast<std::size_t>(longest - edges.begin());
    return {edges[(i + 1) % 3], edges[(i + 2) % 3]};
}

Vector3 nearest_on_edge(const Vector3 &a_m, const Vector3 &b_m, const Vector3 &point_m) {
    const Vector3 edge = b_m - a_m;
    return a_m + std::clamp((point_m - a_m).dot(edge) / edge.squaredNorm(), 0.0, 1.0) * edge;
}

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

/// Whether a segment comes into a box about a triangle, or as near as a crossing may be to the
/// triangle, by their separating axes: the box's three, and those square to the segment.
bool comes_into(const Eigen::AlignedBox3d &box, const Vector3 &from_m, const Vector3 &to_m) {
    const Vector3 half_m =
        0.5 * box.diagonal() + Vector3::Constant(2.0 * kMaxRim_m); // see beyond_m
    const Vector3 half_way_m = 0.5 * (to_m - from_m);
    const Vector3 apart_m = from_m + half_way_m - box.center();
    const Vector3 reach_m = half_way_m.cwiseAbs();
    if (((apart_m.cwiseAbs() - half_m - reach_m).array() > 0.0).any()) {
        return false;
    }
    const Vector3 moment_m2 = apart_m.cross(half_way_m).cwiseAbs();
    for (Eigen::Index i = 0; i < 3; ++i) {
        const Eigen::Index j = (i + 1) % 3;
        const Eigen::Index k = (i + 2) % 3;
        if (moment_m2[i] > half_m[j] * reach_m[k] + half_m[k] * reach_m[j]) {
            return false;
        }
    }
    return true;
}

constexpr std::uint32_t kMaxInLeaf = 4;

} // namespace

double PlainTriangle::beyond_m(const Vector3 &point_m) const {
    double max_m = -std::numeric_limits<double>::infinity();
    double longest_m = 0.0;
    double beyond_ends_m = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vector3 edge = corners_m[(i + 1) % 3] - corners_m[i];
        const Vector3 from_corner = point_m - corners_m[i];
        max_m = std::max(max_m, edge.cross(normal).normalized().dot(from_corner));
        if (const double length_m = edge.norm(); length_m > longest_m) {
            longest_m = length_m;
            const double along_m = edge.dot(from_corner) / length_m;
            beyond_ends_m = std::max(-along_m, edge.dot(from_corner - edge) / length_m);
        }
    }
    return std::max(max_m, beyond_ends_m);
}

Away PlainTriangle::away(const Vector3 &point_m) const {
    const double height = height_m(point_m);
    if (beyond_m(point_m) <= 0.0) {
        return {std::abs(height), height < 0.0 ? Vector3(-normal) : normal};
    }
    Away nearest{std::numeric_limits<double>::infinity(), normal};
    for (std::size_t i = 0; i < 3; ++i) {
        const Vector3 gap =
            point_m - nearest_on_edge(corners_m[i], corners_m[(i + 1) % 3], point_m);
        const double distance_m = gap.norm();
        if (distance_m < nearest.distance_m) {
            nearest = {distance_m, distance_m > 0.0 ? Vector3(gap / distance_m) : normal};
        }
    }
    return nearest;
}

Eigen::AlignedBox3d PlainTriangle::bounds() const {
    Eigen::AlignedBox3d box(corners_m[0]);
    return box.extend(corners_m[1]).extend(corners_m[2]);
}

double PlainTriangle::sine() const {
    const auto [a, b] = two_shorter_edges(corners_m);
    return a.cross(b).norm() / (a.norm() * b.norm());
}

std::vector<PlainTriangle> plain_triangles(const std::vector<contact::FacetSource> &facets) {
    std::vector<PlainTriangle> triangles;
    triangles.reserve(facets.size());
    for (const contact::FacetSource &facet : facets) {
        const auto [a, b] = two_shorter_edges(facet.corners_m);
        triangles.push_back(
            {facet.corners_m, a.cross(b).normalized(), facet.sides == contact::FacetSides::two});
    }
    return triangles;
}

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

NearbyTriangles::NearbyTriangles(std::span<const PlainTriangle> triangles)
    : triangles_(triangles), order_(triangles.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    std::vector<Vector3> middles_m;
    middles_m.reserve(triangles.size());
    for (const PlainTriangle &triangle : triangles) {
        middles_m.emplace_back(triangle.bounds().center());
    }
    if (!triangles.empty()) {
        nodes_.reserve(triangles.size());
        add(0, static_cast<std::uint32_t>(triangles.size()), middles_m);
    }
}

std::uint32_t NearbyTriangles::add(std::uint32_t first, std::uint32_t last,
                                   const std::vector<Vector3> &middles_m) {
    const auto index = static_cast<std::uint32_t>(nodes_.size());
    Node node;
    node.first = first;
    node.last = last;
    Eigen::AlignedBox3d middles_box;
    for (std::uint32_t i = first; i < last; ++i) {
        node.box.extend(triangles_[order_[i]].bounds());
        middles_box.extend(middles_m[order_[i]]);
    }
    nodes_.push_back(node);
    if (last - first > kMaxInLeaf) {
        Eigen::Index axis = 0;
        middles_box.diagonal().maxCoeff(&axis);
        const std::uint32_t half = first + (last - first) / 2;
        std::nth_element(order_.begin() + first, order_.begin() + half, order_.begin() + last,
                         [&](std::uint32_t a, std::uint32_t b) {
                             return middles_m[a][axis] < middles_m[b][axis];
                         });
        add(first, half, middles_m);
        const std::uint32_t other = add(half, last, middles_m);
        nodes_[index].other = other;
    }
    return index;
}

template <typename IsNear, typename Visit>
void NearbyTriangles::search(const IsNear &is_near, const Visit &visit) const {
    std::array<std::uint32_t, 64> waiting{}; // at most one for each halving
    std::size_t count = nodes_.empty() ? 0 : 1;
    while (count > 0) {
        const std::uint32_t index = waiting[--count];
        const Node &node = nodes_[index];
        if (!is_near(node.box)) {
            continue;
        }
        if (node.other != 0) {
            waiting[count++] = node.other;
            waiting[count++] = index + 1;
            continue;
        }
        for (std::uint32_t i = node.first; i < node.last; ++i) {
            if (is_near(triangles_[order_[i]].bounds()) && visit(order_[i])) {
                return;
            }
        }
    }
}

std::vector<std::size_t> NearbyTriangles::within(const Vector3 &centre_m, double radius_m) const {
    std::vector<std::size_t> found;
    const auto is_near = [&](const Eigen::AlignedBox3d &box) {
        return box.squaredExteriorDistance(centre_m) <= radius_m * radius_m;
    };
    search(is_near, [&](std::uint32_t triangle) {
        found.push_back(triangle);
        return false;
    });
    std::ranges::sort(found);
    return found;
}

std::optional<std::size_t> NearbyTriangles::crossed(const Vector3 &from_m,
                                                    const Vector3 &to_m) const {
    std::optional<std::size_t> found;
    const auto is_near = [&](const Eigen::AlignedBox3d &box) {
        return comes_into(box, from_m, to_m);
    };
    search(is_near, [&](std::uint32_t triangle) {
        if (goes_through(triangles_[triangle], from_m, to_m)) {
            found = triangle;
        }
        return found.has_value();
    });
    return found;
}

namespace {

constexpr double kMaxStep_m = 50e-6;
constexpr int kMaxSteps = 50'000;

/// What starts too close may come closer by this in a step [m]: round-off.
constexpr double kMayLoseMore_m = 1e-14;

/// Where Newton's method ends [m].
constexpr double kReached_m = 1e-13;

/// A motion this flat to a push does not oppose it [rad]: the push of an edge that is 10 nm
/// away is known to no better than round-off, 1e-16 m, leaves of its direction.
constexpr double kFlat = 1e-7;

/// Behind a one-sided triangle, or in a solid, means deeper than round-off [m].
constexpr double kBehind_m = 1e-12;

/// Radius within which obstacles are listed before the list is renewed [m].
constexpr double kListed_m = 2e-4;

} // namespace

Vector3 unopposed_part(const Vector3 &desired, std::span<const Vector3> pushes) {
    Vector3 best = Vector3::Zero(); // always admissible
    double minimum = desired.squaredNorm();
    const auto consider = [&](const Vector3 &way) {
        const double missing = (way - desired).squaredNorm();
        const double flat = kFlat * way.norm();
        if (missing < minimum && std::ranges::all_of(pushes, [&](const Vector3 &push) {
                return push.dot(way) >= -flat;
            })) {
            best = way;
            minimum = missing;
        }
    };
    consider(desired);
    for (std::size_t i = 0; i < pushes.size(); ++i) {
        consider(desired - desired.dot(pushes[i]) * pushes[i]);
        for (std::size_t j = i + 1; j < pushes.size(); ++j) {
            const Vector3 edge = pushes[i].cross(pushes[j]);
            const double sine = edge.norm();
            if (sine > kFlat) {
                consider(desired.dot(edge) / (sine * sine) * edge);
            }
        }
    }
    return best;
}

BruteForceProxy::BruteForceProxy(std::span<const PlainTriangle> triangles,
                                 std::span<const contact::AnalyticShape> shapes, double slack_m)
    : triangles_(triangles), shapes_(shapes), slack_m_(slack_m), nearby_(triangles) {}

std::vector<std::size_t> BruteForceProxy::within(const Vector3 &centre_m, double radius_m) const {
    std::vector<std::size_t> found = nearby_.within(centre_m, radius_m);
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
        found.push_back(triangles_.size() + i);
    }
    return found;
}

bool BruteForceProxy::stops_what_is_at(std::size_t obstacle, const Vector3 &point_m) const {
    if (obstacle < triangles_.size()) {
        const PlainTriangle &triangle = triangles_[obstacle];
        return triangle.two_sided || triangle.height_m(point_m) >= -kBehind_m;
    }
    return shapes_[obstacle - triangles_.size()].nearest(point_m).distance_m >= -kBehind_m;
}

Away BruteForceProxy::away(std::size_t obstacle, const Vector3 &point_m) const {
    if (obstacle < triangles_.size()) {
        return triangles_[obstacle].away(point_m);
    }
    const contact::NearestOnShape nearest = shapes_[obstacle - triangles_.size()].nearest(point_m);
    return {nearest.distance_m, nearest.normal};
}

/// How far a motion goes until the obstacle is no farther than `level_m`; `length_m` if never.
double BruteForceProxy::length_until_m(std::size_t obstacle, double level_m, const Vector3 &from_m,
                                       const Vector3 &direction, double length_m) const {
    double gone_m = 0.0;
    for (int i = 0; i < 60; ++i) {
        const Away there = away(obstacle, from_m + gone_m * direction);
        const double left_m = there.distance_m - level_m;
        if (left_m <= kReached_m) {
            break;
        }
        const double slope = there.direction.dot(direction);
        if (slope >= 0.0 || gone_m - left_m / slope >= length_m) {
            return length_m;
        }
        gone_m -= left_m / slope;
    }
    return gone_m;
}

BruteForceProxy::Free BruteForceProxy::free_way(const std::vector<std::size_t> &listed,
                                                const Vector3 &from_m, const Vector3 &direction,
                                                double length_m, double reach_m) const {
    Free free{length_m, std::nullopt};
    for (const std::size_t i : listed) {
        if (!stops_what_is_at(i, from_m)) {
            continue;
        }
        const Away start = away(i, from_m);
        if (start.direction.dot(direction) >= 0.0) {
            continue; // farther all along the motion
        }
        // Newton's method ends a little above its level, hence the lower one.
        const double min_m =
            std::min(reach_m - slack_m_, start.distance_m - kMayLoseMore_m) - kReached_m;
        if (length_until_m(i, min_m, from_m, direction, free.length_m) < free.length_m) {
            free = {length_until_m(i, reach_m, from_m, direction, free.length_m), i};
        }
    }
    return free;
}

/// One step down; false where there is none to take.
bool BruteForceProxy::step(const std::vector<std::size_t> &listed, const Vector3 &target_m,
                           double reach_m, End &end) const {
    const Vector3 desired = target_m - end.point_m;
    // Its drift towards a push that is turned by round-off stays within half of the slack.
    const double longest_m = std::min(kMaxStep_m, 0.5 * slack_m_ / kFlat);
    std::vector<std::size_t> blocking;
    std::vector<Vector3> pushes;
    for (;;) {
        const Vector3 way = unopposed_part(desired, pushes);
        const double way_m = way.norm();
        if (way_m <= 1e-9 + 2.0 * kFlat * desired.norm()) {
            end.is_lowest = true;
            return false;
        }
        const Vector3 direction = way / way_m;
        const Free free =
            free_way(listed, end.point_m, direction, std::min(way_m, longest_m), reach_m);
        if (free.length_m > kReached_m) {
            end.point_m += free.length_m * direction;
            break;
        }
        if (std::ranges::find(blocking, *free.blocked_by) != blocking.end()) {
            return false; // step limit
        }
        blocking.push_back(*free.blocked_by);
        pushes.push_back(away(*free.blocked_by, end.point_m).direction);
    }
    // What it slid along, and may have approached by a part of the slack.
    for (const std::size_t i : blocking) {
        const Away there = away(i, end.point_m);
        const double missing_m = reach_m - there.distance_m;
        if (missing_m > 0.0 && missing_m < slack_m_) {
            end.point_m += missing_m * there.direction;
        }
    }
    return true;
}

BruteForceProxy::End BruteForceProxy::walk(const Vector3 &from_m, const Vector3 &target_m,
                                           double reach_m) const {
    End end{from_m, false};
    Vector3 listed_about_m = from_m;
    std::vector<std::size_t> listed = within(from_m, kListed_m + reach_m);
    for (int i = 0; i < kMaxSteps && step(listed, target_m, reach_m, end); ++i) {
        if ((end.point_m - listed_about_m).norm() > kListed_m - 2.0 * kMaxStep_m) {
            listed_about_m = end.point_m;
            listed = within(listed_about_m, kListed_m + reach_m);
        }
    }
    return end;
}

std::optional<Vector3> BruteForceProxy::hop(const Vector3 &from_m, const Vector3 &target_m,
                                            double reach_m) const {
    constexpr int kDirections = 32;
    const std::vector<std::size_t> listed = within(from_m, 2.0 * kHop_m + reach_m);
    const Vector3 up = (from_m - target_m).normalized();
    const Vector3 across = up.unitOrthogonal();
    const Vector3 above_m = from_m + free_way(listed, from_m, up, kHop_m, reach_m).length_m * up;
    std::optional<Vector3> nearest_m;
    double min_m = (from_m - target_m).norm() - kHop_m;
    for (int i = 0; i < kDirections; ++i) {
        const Eigen::AngleAxisd turn(2.0 * std::numbers::pi * i / kDirections, up);
        const Vector3 sideways = turn * across;
        if (free_way(listed, above_m, sideways, kHop_m, reach_m).blocked_by) {
            continue;
        }
        const Vector3 end_m = walk(above_m + kHop_m * sideways, target_m, reach_m).point_m;
        if (const double distance_m = (end_m - target_m).norm(); distance_m < min_m) {
            min_m = distance_m;
            nearest_m = end_m;
        }
    }
    return nearest_m;
}

} // namespace springdrive::rig

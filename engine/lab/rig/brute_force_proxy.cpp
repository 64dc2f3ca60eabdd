#include "engine/lab/rig/brute_force_proxy.h"

#include <algorithm>
#include <cmath>

namespace springdrive::rig {

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

} // namespace springdrive::rig

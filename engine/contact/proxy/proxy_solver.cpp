#include "engine/contact/proxy/proxy_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace springdrive::contact {

namespace {

/// A proxy this near to its goal has arrived [m] and does not move: smaller differences between two
/// solutions for the same planes are round-off.
constexpr double kStill_m = 1e-11;

/// A plane that has turned by less than this [rad] since it was found counts as the same.
constexpr double kSamePlane = 1e-9;

/// Cosine of the largest angle by which a shape's normal may turn along a slide whose end is
/// predicted. A longer slide would leave the surface more than follow it.
constexpr double kGentle = 0.9;

/// Around a curved offset, each slide along a tangent plane leaves a nearly constant fraction of
/// the remaining distance: once it is known, so is the sum of the remaining slides (Aitken).
class SlideExtrapolation {
public:
    /// The length of all remaining slides, this one included, as a multiple of this one.
    [[nodiscard]] double stretch(const Vector3 &slide_m) noexcept {
        const double length_m = slide_m.norm();
        const double share = last_length_m_ > 0.0 ? length_m / last_length_m_ : 0.0;
        const bool is_row =
            share > 0.2 && share < 0.99 && slide_m.dot(last_m_) > 0.7 * length_m * last_length_m_;
        last_m_ = slide_m;
        last_length_m_ = is_row ? 0.0 : length_m; // a stretched one begins a new sequence
        return is_row ? 1.0 / (1.0 - share) : 1.0;
    }

private:
    Vector3 last_m_{Vector3::Zero()};
    double last_length_m_ = 0.0;
};

/// By what multiple a slide reaches the point at which the target is `max_m` away again: beyond
/// it, the proxy would move away from its target. Where the target is already farther, the point at
/// which it is nearest.
double times_within(double max_m, const Vector3 &slide_m, const Vector3 &to_target_m) noexcept {
    const double slide_m2 = slide_m.squaredNorm();
    const double along_m2 = slide_m.dot(to_target_m);
    const double left_m2 = max_m * max_m - to_target_m.squaredNorm();
    return (along_m2 + std::sqrt(std::max(0.0, along_m2 * along_m2 + slide_m2 * left_m2))) /
           slide_m2;
}

} // namespace

void ProxySolver::move(Rest &rest, const Vector3 &to_m) const noexcept {
    rest.point_m = to_m;
    path_.add(to_m);
}

/// Where a slide along a single shape is to end: straight above the place of rest, so that it only
/// has to drop from there. For a convex shape that is above its point nearest to the target. With
/// more than one plane active, such an end might lie below the others.
std::optional<Vector3> ProxySolver::above_rest(const ContactPlanes &planes,
                                               const Vector3 &target_m) const noexcept {
    const AnalyticShape *shape = planes.size() == 1 ? surface_.shape(planes[0].obstacle) : nullptr;
    if (shape == nullptr) {
        return std::nullopt;
    }
    const Vector3 up = shape->nearest(target_m).normal;
    const double slant = up.dot(planes[0].normal);
    if (slant < kGentle) {
        return std::nullopt; // another side of it is nearer
    }
    return Vector3(target_m - planes[0].height_m(target_m) / slant * up);
}

/// A convex shape alone: every slide around it leads to the same place.
bool ProxySolver::is_on_one_shape(const ContactPlanes &planes) const noexcept {
    return planes.size() == 1 && surface_.shape(planes[0].obstacle) != nullptr;
}

bool ProxySolver::refresh(ContactPlanes &planes, const Vector3 &point_m) const noexcept {
    ContactPlanes touching;
    bool is_unchanged = true;
    for (const ContactPlane &plane : planes) {
        const std::optional<Stop> touch =
            surface_.touch(plane.obstacle, point_m, reach_m_, touching_within_m(point_m));
        if (!touch) {
            is_unchanged = false;
            continue;
        }
        is_unchanged =
            is_unchanged && (touch->normal - plane.normal).squaredNorm() < kSamePlane * kSamePlane;
        touching.add({touch->normal, touch->offset_m, plane.obstacle});
    }
    planes = touching;
    return is_unchanged;
}

bool ProxySolver::solve(Rest &rest, const Vector3 &target_m) const noexcept {
    const bool is_curved = reach_m_ > kClearance_m || !surface_.shapes().empty();
    const double max_m = (target_m - rest.point_m).norm();
    SlideExtrapolation extrapolation;
    // What holds the proxy if it has to stop early: else the force would fail for a tick.
    ContactPlanes last_met;
    for (const ContactPlane &plane : rest.held_by) {
        if (plane.height_m(target_m) < 0.0) {
            last_met.add(plane);
        }
    }
    ContactPlanes planes = rest.held_by; // the goal stays above these
    NearestPoint goal = nearest_point(target_m, planes, rest.point_m);
    while (budget_.has_any_left()) {
        if ((goal.point_m - rest.point_m).squaredNorm() <= kStill_m * kStill_m) {
            // As far as these planes allow; which of them still touch?
            rest.held_by = goal.active;
            if (refresh(rest.held_by, rest.point_m)) {
                return true;
            }
            budget_.take_motion();
            planes = rest.held_by;
            goal = nearest_point(target_m, planes, rest.point_m);
            continue;
        }
        budget_.take_motion();
        Vector3 end_m = goal.point_m;
        if (is_curved && goal.active.size() > 0) {
            if (const std::optional<Vector3> above_m = above_rest(planes, target_m)) {
                end_m = *above_m;
            } else {
                const Vector3 slide_m = goal.point_m - rest.point_m;
                double times = extrapolation.stretch(slide_m);
                if (!is_on_one_shape(planes)) {
                    times = std::min(times, times_within(max_m, slide_m, target_m - rest.point_m));
                }
                end_m = rest.point_m + times * slide_m;
            }
        }
        const std::optional<SurfaceStop> hit = first_stop(rest.point_m, end_m);
        if (!hit) {
            move(rest, end_m);
            if (is_curved) {
                planes = goal.active;
                static_cast<void>(refresh(planes, rest.point_m));
                goal = nearest_point(target_m, planes, rest.point_m);
            }
            continue;
        }
        if (hit->stop.fraction > 0.0) {
            move(rest, rest.point_m + hit->stop.fraction * (end_m - rest.point_m));
        }
        if (!hit->is_known) {
            rest.held_by = goal.active;
            break;
        }
        const ContactPlane plane{hit->stop.normal, hit->stop.offset_m, hit->obstacle};
        if (hit->stop.fraction == 0.0 && plane.height_m(end_m) >= -kRoundOff_m) {
            move(rest, end_m); // which lies above this plane except for round-off
            continue;
        }
        last_met = ContactPlanes();
        last_met.add(plane);
        planes = goal.active;
        planes.add(plane);
        goal = nearest_point(target_m, planes, rest.point_m);
    }
    // Stopped early, perhaps just above the surface that it was descending to.
    static_cast<void>(refresh(rest.held_by, rest.point_m));
    if (!rest.is_touching()) {
        rest.held_by = last_met;
    }
    return false;
}

std::optional<SurfaceStop> ProxySolver::first_stop(const Vector3 &from_m,
                                                   const Vector3 &to_m) const noexcept {
    if (!near_.covers(from_m, reach_m_)) {
        return surface_.first_stop(from_m, to_m, reach_m_, budget_.search);
    }
    const double covered = near_.covered_fraction(from_m, to_m, reach_m_);
    if (covered == 1.0) {
        return surface_.first_stop(near_, from_m, to_m, reach_m_, budget_.search);
    }
    const Vector3 leaves_m = from_m + covered * (to_m - from_m);
    if (std::optional<SurfaceStop> hit =
            surface_.first_stop(near_, from_m, leaves_m, reach_m_, budget_.search)) {
        hit->stop.fraction *= covered;
        return hit;
    }
    std::optional<SurfaceStop> hit = surface_.first_stop(leaves_m, to_m, reach_m_, budget_.search);
    if (hit) {
        hit->stop.fraction = covered + (1.0 - covered) * hit->stop.fraction;
    }
    return hit;
}

namespace {

/// A point no farther than this from an edge lies on it [m]: at a vertex of several facets, the one
/// nearest to the proxy need not be an end of the edge that leads on.
constexpr double kOnEdge_m = 3.0 * kClearance_m;

/// A projection shorter than this has no reliable direction [m].
constexpr double kMinLength_m = 1e-9;

/// Whether a facet's box comes within a distance of a point: a quick, conservative test.
[[nodiscard]] bool may_come_within(double within_m, const Facet &facet,
                                   const Vector3 &point_m) noexcept {
    const auto &[a, b, c] = facet.corners_m();
    for (int axis = 0; axis < 3; ++axis) {
        const double lower_m = std::min(a[axis], std::min(b[axis], c[axis]));
        const double upper_m = std::max(a[axis], std::max(b[axis], c[axis]));
        if (lower_m - within_m > point_m[axis] || upper_m + within_m < point_m[axis]) {
            return false;
        }
    }
    return true;
}

/// The search at one vertex. Whether a facet belongs to the vertex is found out only where a
/// direction depends on it.
class Vertex {
public:
    // Facets beyond size_ are never read. NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init)
    Vertex(const Vector3 &point_m, const Vector3 &target_m, double within_m,
           const MotionsAbove &motions) noexcept
        : point_m_(point_m), to_target_m_(target_m - point_m), target_m_(target_m),
          within_m_(within_m), motions_(motions) {}

    void consider(const Facet &facet) noexcept {
        if (size_ < fan_.size() && may_come_within(within_m_, facet, point_m_)) {
            Leaf &leaf = fan_[size_++];
            leaf.facet = &facet;
            leaf.is_known = false;
        }
    }

    [[nodiscard]] DownhillDirections directions() noexcept {
        DownhillDirections found;
        for (std::size_t i = 0; i < size_; ++i) {
            add_plane(fan_[i], found);
            add_edges(fan_[i], found);
        }
        return found;
    }

private:
    /// Set before it is read. NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init)
    struct Leaf {
        const Facet *facet;
        bool is_known;     ///< what follows
        bool is_near;      ///< whether it belongs to the vertex
        Vector3 nearest_m; ///< to the proxy
    };

    /// Whether a facet belongs to the vertex; if it does, `nearest_m` is set from then on.
    [[nodiscard]] bool is_near(Leaf &leaf) const noexcept {
        if (!leaf.is_known) {
            const Facet &facet = *leaf.facet;
            leaf.nearest_m = facet.is_over(point_m_)
                                 ? Vector3(point_m_ - facet.height_m(point_m_) * facet.normal())
                                 : facet.nearest(point_m_).point_m;
            leaf.is_near = (leaf.nearest_m - point_m_).squaredNorm() <= within_m_ * within_m_;
            leaf.is_known = true;
        }
        return leaf.is_near;
    }

    [[nodiscard]] bool is_over_any(const Vector3 &point_m) noexcept {
        return std::any_of(fan_.begin(), fan_.begin() + size_, [&](Leaf &leaf) {
            return leaf.facet->is_over(point_m) && is_near(leaf);
        });
    }

    void add_plane(Leaf &leaf, DownhillDirections &found) noexcept {
        const Facet &facet = *leaf.facet;
        const Vector3 along_m = to_target_m_ - facet.normal().dot(to_target_m_) * facet.normal();
        const double distance_m = along_m.norm();
        const Vector3 along = along_m / distance_m;
        if (distance_m > kMinLength_m && motions_.contain(along) && is_near(leaf)) {
            const Vector3 end_m = leaf.nearest_m + motions_.length_m() * along;
            if (facet.is_over(end_m) || !is_over_any(end_m)) {
                found.add(along);
            }
        }
    }

    void add_edges(Leaf &leaf, DownhillDirections &found) const noexcept {
        const std::array<Vector3, 3> &corners_m = leaf.facet->corners_m();
        for (std::size_t i = 0; i < 3; ++i) {
            const Vector3 edge = corners_m[(i + 1) % 3] - corners_m[i];
            const double edge_m = edge.norm();
            const Vector3 along = edge / edge_m;
            const double ahead_m = along.dot(to_target_m_); // but for `within_m_`
            if (((ahead_m > -within_m_ && motions_.contain(along)) ||
                 (ahead_m < within_m_ && motions_.contain(-along))) &&
                is_near(leaf)) {
                add_edge(leaf.nearest_m, corners_m[i], along, edge_m, found);
            }
        }
    }

    void add_edge(const Vector3 &from_m, const Vector3 &start_m, const Vector3 &along,
                  double edge_m, DownhillDirections &found) const noexcept {
        const double passed_m = along.dot(from_m - start_m);
        if ((start_m + passed_m * along - from_m).squaredNorm() > kOnEdge_m * kOnEdge_m) {
            return;
        }
        const bool is_forward = along.dot(target_m_ - from_m) > 0.0;
        const Vector3 direction = is_forward ? along : Vector3(-along);
        if ((is_forward ? edge_m - passed_m : passed_m) > motions_.length_m() &&
            motions_.contain(direction)) {
            found.add(direction);
        }
    }

    const Vector3 &point_m_;
    const Vector3 to_target_m_;
    const Vector3 &target_m_;
    double within_m_;
    const MotionsAbove &motions_;
    std::array<Leaf, Neighbourhood::kCapacity> fan_;
    std::size_t size_ = 0;
};

} // namespace

DownhillDirections downhill_directions(const HapticSurface &surface, const Neighbourhood &near,
                                       const Vector3 &point_m, const Vector3 &target_m,
                                       double within_m, const MotionsAbove &motions) noexcept {
    Vertex vertex(point_m, target_m, within_m, motions);
    near.for_each_in_the_way(point_m, point_m, within_m, [&](std::uint32_t index) noexcept {
        vertex.consider(surface.facet(index));
    });
    return vertex.directions();
}

} // namespace springdrive::contact

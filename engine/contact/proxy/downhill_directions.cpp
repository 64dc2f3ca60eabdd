#include "engine/contact/proxy/downhill_directions.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace springdrive::contact {

namespace {

/// A point no farther than this from an edge lies on it [m]: at a vertex of several facets, the one
/// nearest to the proxy need not be an end of the edge that leads on.
constexpr double kOnEdge_m = kClearance_m;

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

#include "engine/contact/proxy/downhill_directions.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

namespace springdrive::contact {

namespace {

/// A point no farther than this from an edge lies on it [m].
constexpr double kOnEdge_m = 1e-9;

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
        if (size_ < facets_.size() && may_come_within(within_m_, facet, point_m_)) {
            facets_[size_++] = &facet;
        }
    }

    [[nodiscard]] DownhillDirections directions() const noexcept {
        DownhillDirections found;
        for (std::size_t i = 0; i < size_; ++i) {
            add_plane(*facets_[i], found);
            add_edges(*facets_[i], found);
        }
        return found;
    }

private:
    /// The point of a facet nearest to the proxy, if it belongs to the vertex.
    [[nodiscard]] std::optional<Vector3> nearest_m(const Facet &facet) const noexcept {
        const Vector3 nearest_m = facet.nearest(point_m_).point_m;
        const bool is_near = (nearest_m - point_m_).squaredNorm() <= within_m_ * within_m_;
        return is_near ? std::optional(nearest_m) : std::nullopt;
    }

    [[nodiscard]] bool is_over_any(const Vector3 &point_m) const noexcept {
        return std::any_of(facets_.begin(), facets_.begin() + size_, [&](const Facet *facet) {
            return facet->is_over(point_m) && nearest_m(*facet);
        });
    }

    void add_plane(const Facet &facet, DownhillDirections &found) const noexcept {
        const Vector3 along_m = to_target_m_ - facet.normal().dot(to_target_m_) * facet.normal();
        const double distance_m = along_m.norm();
        const Vector3 along = along_m / distance_m;
        if (distance_m <= kMinLength_m || !motions_.contain(along)) {
            return;
        }
        if (const std::optional<Vector3> from_m = nearest_m(facet)) {
            const Vector3 end_m = *from_m + motions_.length_m() * along;
            if (facet.is_over(end_m) || !is_over_any(end_m)) {
                found.add(along);
            }
        }
    }

    void add_edges(const Facet &facet, DownhillDirections &found) const noexcept {
        for (std::size_t i = 0; i < 3; ++i) {
            const Vector3 &start_m = facet.corners_m()[i];
            const Vector3 edge = facet.corners_m()[(i + 1) % 3] - start_m;
            const double edge_m = edge.norm();
            const Vector3 along = edge / edge_m;
            const double ahead_m = along.dot(to_target_m_); // but for `within_m_`
            if ((ahead_m > -within_m_ && motions_.contain(along)) ||
                (ahead_m < within_m_ && motions_.contain(-along))) {
                add_edge(facet, start_m, along, edge_m, found);
            }
        }
    }

    void add_edge(const Facet &facet, const Vector3 &start_m, const Vector3 &along, double edge_m,
                  DownhillDirections &found) const noexcept {
        const std::optional<Vector3> from_m = nearest_m(facet);
        if (!from_m) {
            return;
        }
        const double passed_m = along.dot(*from_m - start_m);
        if ((start_m + passed_m * along - *from_m).squaredNorm() > kOnEdge_m * kOnEdge_m) {
            return;
        }
        const bool is_forward = along.dot(target_m_ - *from_m) > 0.0;
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
    std::array<const Facet *, Neighbourhood::kCapacity> facets_;
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

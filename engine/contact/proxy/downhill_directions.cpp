#include "engine/contact/proxy/downhill_directions.h"

namespace springdrive::contact {

namespace {

/// A point no farther than this from an edge lies on it [m].
constexpr double kOnEdge_m = 1e-9;

/// A projection shorter than this has no reliable direction [m].
constexpr double kMinLength_m = 1e-9;

/// @param from_m  the point of the facet nearest to the proxy
void add_edges(const Facet &facet, const Vector3 &from_m, const Vector3 &target_m, double length_m,
               DownhillDirections &directions) noexcept {
    for (std::size_t i = 0; i < 3; ++i) {
        const Vector3 &start_m = facet.corners_m()[i];
        const Vector3 edge = facet.corners_m()[(i + 1) % 3] - start_m;
        const double edge_m = edge.norm();
        const Vector3 along = edge / edge_m;
        const double passed_m = along.dot(from_m - start_m);
        if ((start_m + passed_m * along - from_m).squaredNorm() > kOnEdge_m * kOnEdge_m) {
            continue;
        }
        const bool is_forward = along.dot(target_m - from_m) > 0.0;
        if ((is_forward ? edge_m - passed_m : passed_m) > length_m) {
            directions.add(is_forward ? along : Vector3(-along));
        }
    }
}

/// The facets that meet at a vertex, in so far as there is room.
class Fan {
public:
    struct Leaf {
        const Facet *facet = nullptr;
        Vector3 nearest_m{Vector3::Zero()}; ///< to the proxy
    };

    void add(const Leaf &leaf) noexcept {
        if (size_ < leaves_.size()) {
            leaves_[size_++] = leaf;
        }
    }

    [[nodiscard]] const Leaf *begin() const noexcept { return leaves_.data(); }
    [[nodiscard]] const Leaf *end() const noexcept { return leaves_.data() + size_; }

    [[nodiscard]] bool is_below(const Vector3 &point_m) const noexcept {
        return std::any_of(begin(), end(),
                           [&](const Leaf &leaf) { return leaf.facet->is_over(point_m); });
    }

private:
    std::array<Leaf, DownhillDirections::kCapacity> leaves_;
    std::size_t size_ = 0;
};

} // namespace

DownhillDirections downhill_directions(const HapticSurface &surface, const Neighbourhood &near,
                                       const Vector3 &point_m, const Vector3 &target_m,
                                       double within_m, double length_m) noexcept {
    Fan fan;
    near.for_each_in_the_way(point_m, point_m, within_m, [&](std::uint32_t index) noexcept {
        const Facet &facet = surface.facet(index);
        const Vector3 nearest_m = facet.nearest(point_m).point_m;
        if ((nearest_m - point_m).squaredNorm() <= within_m * within_m) {
            fan.add({&facet, nearest_m});
        }
    });
    DownhillDirections directions;
    const Vector3 to_target_m = target_m - point_m;
    for (const auto &[facet, nearest_m] : fan) {
        const Vector3 along_m = to_target_m - facet->normal().dot(to_target_m) * facet->normal();
        const double distance_m = along_m.norm();
        if (distance_m > kMinLength_m) {
            const Vector3 along = along_m / distance_m;
            const Vector3 end_m = nearest_m + length_m * along;
            if (facet->is_over(end_m) || !fan.is_below(end_m)) {
                directions.add(along);
            }
        }
        add_edges(*facet, nearest_m, target_m, length_m, directions);
    }
    return directions;
}

} // namespace springdrive::contact

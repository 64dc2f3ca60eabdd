#include "engine/contact/mesh/triangle_orientation.h"

#include "base/cancellation.h"
#include "engine/contact/mesh/triangle_sets.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace springdrive::contact {

namespace {

constexpr double kClearMajority = 2.0 / 3.0;

/// Volumes below this times area^1.5 are round-off: a foil of 10 µm, 10 cm square, has 1e-4 of it.
constexpr double kMinVolumeRatio = 1e-9;

/// What decides which way a patch is turned.
struct Patch {
    bool is_orientable = true;
    double area = 0.0;                ///< twice the area, as all areas here [m²]
    double area_of_first = 0.0;       ///< wound as the patch's first triangle, of one winding only
    double area_of_others = 0.0;      ///< wound the other way, of one winding only
    Vector3 moment = Vector3::Zero(); ///< area times place [m³]
    double volume = 0.0; ///< six times the volume up to the middle, wound as the first triangle
                         ///< [m³]

    [[nodiscard]] double voting_area() const { return area_of_first + area_of_others; }

    [[nodiscard]] bool is_first_right() const {
        const double larger = std::max(area_of_first, area_of_others);
        const bool has_inside = std::abs(volume) > kMinVolumeRatio * std::pow(area, 1.5);
        if (larger < kClearMajority * voting_area() && has_inside) {
            return volume > 0.0;
        }
        return area_of_first >= area_of_others;
    }
};

class Orientation {
public:
    Orientation(std::vector<MeshTriangle> &triangles, const std::vector<Vector3> &vertices_m)
        : triangles_(triangles), vertices_m_(vertices_m), sets_(triangles.size()),
          patch_of_root_(triangles.size()) {}

    void connect(const EdgeTable &edges) {
        std::vector<std::uint32_t> at_odds;
        edges.for_each([&](const Edge &edge) {
            if (edge.is_manifold() && !sets_.unite(edge.uses[0].triangle(), edge.uses[1].triangle(),
                                                   edge.is_run_twice_the_same_way())) {
                at_odds.push_back(edge.uses[0].triangle());
            }
        });
        for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
            if (sets_.root_of(i) == i) {
                patch_of_root_[i] = static_cast<std::uint32_t>(patches_.size());
                patches_.emplace_back();
            }
        }
        for (const std::uint32_t triangle : at_odds) {
            patches_[patch_of_root_[sets_.root_of(triangle)]].is_orientable = false;
        }
    }

    void collect_votes() {
        for_each([&](const MeshTriangle &triangle, Patch &patch, bool is_opposite) {
            const auto [a, b, c] = corners_m(triangle);
            const double area = (b - a).cross(c - a).norm();
            patch.area += area;
            patch.moment += area / 3.0 * (a + b + c);
            if (!triangle.has_both_windings) {
                (is_opposite ? patch.area_of_others : patch.area_of_first) += area;
            }
        });
        for_each([&](const MeshTriangle &triangle, Patch &patch, bool is_opposite) {
            const auto [a, b, c] = corners_m(triangle);
            const Vector3 middle_m = patch.moment / patch.area;
            const double volume = (a - middle_m).dot((b - middle_m).cross(c - middle_m));
            patch.volume += is_opposite ? -volume : volume;
        });
    }

    TurnedTriangles turn() {
        std::vector<bool> is_first_right;
        for (const Patch &patch : patches_) {
            is_first_right.push_back(patch.is_first_right());
        }
        TurnedTriangles turned;
        for_each([&](MeshTriangle &triangle, const Patch &patch, bool is_opposite) {
            const auto number = static_cast<std::size_t>(&patch - patches_.data());
            if (patch.is_orientable && is_opposite == is_first_right[number]) {
                std::swap(triangle.vertices[1], triangle.vertices[2]);
                ++(triangle.has_both_windings ? turned.of_both : turned.of_one_winding);
            }
        });
        return turned;
    }

private:
    template <typename Visit> void for_each(Visit visit) {
        for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
            stop_if_given_up(i);
            const TriangleSets::Place place = sets_.place_of(i);
            visit(triangles_[i], patches_[patch_of_root_[place.root]], place.is_opposite);
        }
    }

    [[nodiscard]] std::array<Vector3, 3> corners_m(const MeshTriangle &triangle) const {
        const auto &[a, b, c] = triangle.vertices;
        return {vertices_m_[a], vertices_m_[b], vertices_m_[c]};
    }

    std::vector<MeshTriangle> &triangles_;
    const std::vector<Vector3> &vertices_m_;
    TriangleSets sets_;
    std::vector<std::uint32_t> patch_of_root_;
    std::vector<Patch> patches_;
};

} // namespace

TurnedTriangles orient_triangles(std::vector<MeshTriangle> &triangles, const EdgeTable &edges,
                                 const std::vector<Vector3> &vertices_m) {
    bool is_consistent = true;
    edges.for_each([&](const Edge &edge) {
        is_consistent = is_consistent && !edge.is_run_twice_the_same_way();
    });
    if (is_consistent) {
        return {};
    }
    Orientation orientation(triangles, vertices_m);
    orientation.connect(edges);
    orientation.collect_votes();
    return orientation.turn();
}

} // namespace springdrive::contact

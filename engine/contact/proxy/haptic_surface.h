// The touchable geometry of a scene: triangles and shapes in metres, device frame, prepared and
// searchable.
#pragma once

#include "base/vector.h"
#include "engine/contact/bvh/box_tree.h"
#include "engine/contact/mesh/facet.h"
#include "engine/contact/mesh/mesh_report.h"
#include "engine/contact/mesh/triangle_soup.h"
#include "engine/contact/proxy/analytic_shape.h"
#include "engine/contact/proxy/neighbourhood.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace springdrive::contact {

struct TriangleSoup;

/// Where a motion from a to b has to end, at a + stop.fraction (b − a), and which obstacle stops
/// it.
struct SurfaceStop {
    Stop stop;
    std::uint32_t obstacle = 0; ///< see HapticSurface
    bool is_known = true;       ///< false: the search ended here because the budget ran out
};

/// A point of an obstacle, with what a contact reports of it.
struct SurfacePoint {
    Vector3 point_m{Vector3::Zero()};
    Vector3 barycentric{Vector3::Zero()}; ///< zero on a shape
    std::uint32_t triangle = 0;           ///< of the soup; on a shape the soup's size + its index
    std::uint16_t material = 0;
};

/// Immutable: any number of threads may query it at once. An empty surface is never touched.
///
/// Surfaces that bound a volume stop the tip from outside only, so that a tip that starts within
/// may leave. All others stop it from both sides. Facets and shapes together are its *obstacles*,
/// numbered consecutively: facets first.
class HapticSurface {
public:
    HapticSurface() = default;

    /// Prepares triangles and builds the search structure, in as many threads as there are cores.
    /// @throw std::invalid_argument as `prepare_mesh` does, for a shape without a material, or for
    ///        too many shapes
    explicit HapticSurface(TriangleSoup soup, std::vector<AnalyticShape> shapes = {});

    /// The first stop of a straight motion of a proxy with that reach, if there is one. Where the
    /// budget runs out, the motion ends where it may be too near to what was not looked at.
    /// RT-safe.
    [[nodiscard]] std::optional<SurfaceStop> first_stop(const Vector3 &from_m, const Vector3 &to_m,
                                                        double reach_m,
                                                        SearchBudget &budget) const noexcept;

    /// The same for a motion that a neighbourhood of this surface covers. RT-safe.
    [[nodiscard]] std::optional<SurfaceStop> first_stop(const Neighbourhood &near,
                                                        const Vector3 &from_m, const Vector3 &to_m,
                                                        double reach_m,
                                                        SearchBudget &budget) const noexcept;

    /// Whether a motion from a place that a neighbourhood covers stays in it and is clear of its
    /// facets and of the given shapes. A quick, conservative test: true is certain. RT-safe.
    [[nodiscard]] bool is_clear_of(ShapeSet shapes, const Neighbourhood &near,
                                   const Vector3 &from_m, const Vector3 &to_m,
                                   double reach_m) const noexcept;

    /// How a proxy that rests in `from_m` over a shape's face slides, where certainly no other
    /// obstacle is involved: none stops it or lies nearer to the tip. Nothing where a quick test
    /// cannot decide that. RT-safe.
    /// @pre `near` covers `from_m`, with `reach_m` about it
    [[nodiscard]] std::optional<ShapeSlide> slide_over(std::uint32_t obstacle,
                                                       const Neighbourhood &near,
                                                       const Vector3 &from_m, const Vector3 &tip_m,
                                                       double reach_m) const noexcept;

    /// A list of what is nearer than this saves little [m].
    static constexpr double kMinListedRadius_m = 100.0 * kClearance_m;

    /// Lists what lies within a ball, or within a smaller one where that exceeds the list. The list
    /// covers nothing where even `min_radius_m` does not help, or the budget ran out. RT-safe.
    void find_near(const Vector3 &centre_m, double radius_m, SearchBudget &budget,
                   Neighbourhood &near, double min_radius_m = kMinListedRadius_m) const noexcept;

    /// The plane in which a proxy touches an obstacle, if it is within `within_m` of touching.
    [[nodiscard]] std::optional<Stop> touch(std::uint32_t obstacle, const Vector3 &point_m,
                                            double reach_m, double within_m) const noexcept;

    /// The result of `nearest` for a shape whose nearest point is known. RT-safe.
    [[nodiscard]] SurfacePoint point_on_shape(std::uint32_t obstacle,
                                              const Vector3 &point_m) const noexcept;

    /// The point of an obstacle nearest to `point_m`. RT-safe.
    [[nodiscard]] SurfacePoint nearest(std::uint32_t obstacle,
                                       const Vector3 &point_m) const noexcept;

    [[nodiscard]] const Facet &facet(std::uint32_t index) const noexcept { return facets_[index]; }
    [[nodiscard]] const std::vector<AnalyticShape> &shapes() const noexcept { return shapes_; }

    /// The shape of an obstacle; null for a facet. RT-safe.
    [[nodiscard]] const AnalyticShape *shape(std::uint32_t obstacle) const noexcept {
        return obstacle < facets_.size() ? nullptr : &shapes_[obstacle - facets_.size()];
    }

    /// That of an obstacle. RT-safe.
    [[nodiscard]] const SurfaceMaterial &material(std::uint32_t obstacle) const noexcept {
        return materials_[material_index(obstacle)];
    }
    [[nodiscard]] const std::vector<SurfaceMaterial> &materials() const noexcept {
        return materials_;
    }

    [[nodiscard]] const MeshReport &report() const noexcept { return report_; }

    /// Memory of facets, tree, shapes and materials [bytes].
    [[nodiscard]] std::size_t bytes() const noexcept;

    /// Differs between any two surfaces of a run, except empty ones and copies.
    [[nodiscard]] std::uint64_t serial() const noexcept { return serial_; }

private:
    [[nodiscard]] std::optional<Stop> stop_at_shape(std::size_t shape, const Vector3 &from_m,
                                                    const Vector3 &to_m, double reach_m,
                                                    double last_fraction) const noexcept;
    [[nodiscard]] std::uint32_t facet_of(std::uint32_t item) const noexcept {
        return facet_of_item_.empty() ? item : facet_of_item_[item];
    }
    [[nodiscard]] std::uint16_t material_index(std::uint32_t obstacle) const noexcept;

    std::vector<SurfaceMaterial> materials_;
    MeshReport report_;
    std::vector<Facet> facets_; ///< in the order in which the tree comes to them
    bool has_two_sided_ = false;
    BoxTree tree_;
    std::vector<std::uint32_t> facet_of_item_; ///< of the tree; empty where each is one's own
    std::vector<AnalyticShape> shapes_;
    std::uint64_t serial_ = 0;
};

} // namespace springdrive::contact

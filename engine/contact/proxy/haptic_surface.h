// The touchable geometry of a scene: triangles and shapes in metres, device frame, prepared and
// searchable.
#pragma once

#include "base/vector.h"
#include "engine/contact/bvh/box_tree.h"
#include "engine/contact/mesh/facet.h"
#include "engine/contact/mesh/mesh_report.h"
#include "engine/contact/mesh/triangle_soup.h"
#include "engine/contact/proxy/analytic_shape.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace springdrive::contact {

/// A set of shapes of a surface, one bit each.
using ShapeSet = std::uint64_t;
inline constexpr std::size_t kMaxShapes = 64;

/// A cache of everything touchable near a place: the proxy moves little from tick to tick, and
/// queries the same few facets again and again. Holds the facets and shapes of one surface that
/// intersect a ball. Complete: whatever is not listed lies outside of the ball.
class Neighbourhood {
public:
    /// Entries for facets; two-sided ones take two. Enough for the ring of triangles around a
    /// triangle, few enough to query them all in a few dozen nanoseconds.
    static constexpr int kCapacity = 48;

    /// Empties it, so that it covers no place.
    void clear() noexcept {
        surface_serial_ = 0;
        radius_m_ = 0.0;
        size_ = 0;
        shapes_ = 0;
    }

    /// Begins a list of what intersects a ball; `complete` ends it.
    void begin(std::uint64_t surface_serial, const Vector3 &centre_m) noexcept {
        clear();
        surface_serial_ = surface_serial;
        centre_m_ = centre_m;
    }

    /// @pre there is room for it
    void add(std::uint32_t index, const Facet &facet) noexcept;
    void add_shape(std::size_t shape) noexcept { shapes_ |= ShapeSet{1} << shape; }
    void complete(double radius_m) noexcept;

    [[nodiscard]] std::uint64_t surface_serial() const noexcept { return surface_serial_; }
    [[nodiscard]] const Vector3 &centre_m() const noexcept { return centre_m_; }
    [[nodiscard]] double radius_m() const noexcept { return radius_m_; }
    [[nodiscard]] int size() const noexcept { return size_; }
    [[nodiscard]] ShapeSet shapes() const noexcept { return shapes_; }

    /// Whether nothing is listed but these shapes.
    [[nodiscard]] bool has_only(ShapeSet shapes) const noexcept {
        return size_ == 0 && shapes_ == shapes;
    }

    /// Whether everything within `margin_m` of a point is listed.
    [[nodiscard]] bool covers(const Vector3 &point_m, double margin_m) const noexcept {
        const double left_m = radius_m_ - margin_m;
        return left_m > 0.0 && (point_m - centre_m_).squaredNorm() <= left_m * left_m;
    }

    /// The fraction of a motion that is covered, where its start is.
    [[nodiscard]] double covered_fraction(const Vector3 &from_m, const Vector3 &to_m,
                                          double margin_m) const noexcept;

    /// Calls `visit(facet index)` for facets whose plane the motion may come too near to, from a
    /// side on which they can be touched: usually a few of them.
    template <typename Visit>
    void for_each_in_the_way(const Vector3 &from_m, const Vector3 &to_m, double reach_m,
                             const Visit &visit) const noexcept {
        const double clear_m = reach_m - kSlack_m;
        for (std::size_t row = 0; row < rows(); ++row) {
            const Heights starts_m = planes_[row].heights_m(from_m);
            const Heights ends_m = planes_[row].heights_m(to_m);
            const Heights min_m = starts_m.min(ends_m) + far_if_positive(-starts_m);
            for_each_below(clear_m, min_m, [&](std::size_t i) { visit(index_[row][i]); });
        }
    }

    /// Calls `visit(facet index, depth)` for facets that have the tip behind them, less than
    /// `min_depth_m` deep.
    template <typename Visit>
    void for_each_shallower(const Vector3 &tip_m, double min_depth_m,
                            const Visit &visit) const noexcept {
        for (std::size_t row = 0; row < rows(); ++row) {
            const Heights tips_m = planes_[row].heights_m(tip_m);
            const Heights depths_m = far_if_positive(tips_m) - tips_m;
            for_each_below(min_depth_m, depths_m, [&](std::size_t i) {
                visit(index_[row][i], depths_m[static_cast<int>(i)]);
            });
        }
    }

    /// Whether there is any such facet.
    [[nodiscard]] bool has_shallower(const Vector3 &tip_m, double min_depth_m) const noexcept {
        bool has = false;
        for_each_shallower(tip_m, min_depth_m, [&](std::uint32_t, double) { has = true; });
        return has;
    }

private:
    /// Facets that are tested together; the last row is padded with entries that never stop a
    /// motion.
    static constexpr int kAtOnce = 8;
    static_assert(kCapacity % kAtOnce == 0);
    static constexpr std::size_t kRows = kCapacity / kAtOnce;
    using Heights = Eigen::Array<double, kAtOnce, 1>;

    /// One array for each coordinate, so that the processor handles several facets at a time.
    struct Planes {
        Heights normal_x{Heights::Zero()};
        Heights normal_y{Heights::Zero()};
        Heights normal_z{Heights::Zero()};
        Heights offset_m{Heights::Constant(-1.0)};

        [[nodiscard, gnu::always_inline]] Heights heights_m(const Vector3 &point_m) const noexcept {
            return normal_x * point_m.x() + normal_y * point_m.y() + normal_z * point_m.z() -
                   offset_m;
        }
    };

    [[nodiscard]] std::size_t rows() const noexcept {
        return static_cast<std::size_t>(size_ + kAtOnce - 1) / kAtOnce;
    }

    /// Zero, or far beyond any distance: excludes entries on the wrong side without a branch for
    /// each.
    [[nodiscard, gnu::always_inline]] static Heights far_if_positive(const Heights &m) noexcept {
        return m.max(0.0) * 1e30;
    }

    template <typename Visit>
    [[gnu::always_inline]] static void for_each_below(double limit, const Heights &values,
                                                      const Visit &visit) noexcept {
        if (values.minCoeff() < limit) { // usually none is
            for (int i = 0; i < kAtOnce; ++i) {
                if (values[i] < limit) {
                    visit(static_cast<std::size_t>(i));
                }
            }
        }
    }

    void add_side(std::uint32_t index, double side, const Facet &facet) noexcept;

    std::uint64_t surface_serial_ = 0;
    Vector3 centre_m_{Vector3::Zero()};
    double radius_m_ = 0.0;
    int size_ = 0;
    ShapeSet shapes_ = 0;
    std::array<Planes, kRows> planes_;
    std::array<std::array<std::uint32_t, kAtOnce>, kRows> index_{};
};

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

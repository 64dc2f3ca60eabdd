// Finds motions that pass through a surface, with a uniform grid and the plane of each triangle.
#pragma once

#include "base/vector.h"
#include "engine/lab/rig/plain_triangles.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace springdrive::rig {

/// Whether a straight motion goes through a triangle: of a closed surface from its front, of an
/// open one from either side. A motion that passes the rim by less than 0.1 nm counts as one
/// through it, so that no motion between two triangles is missed; by more if round-off may shift
/// the crossing by more, but not by 5 nm, half of what the proxy keeps.
[[nodiscard]] bool goes_through(const PlainTriangle &triangle, const Vector3 &from_m,
                                const Vector3 &to_m);

class CrossingFinder {
public:
    /// @param triangles  must outlive this
    explicit CrossingFinder(std::span<const PlainTriangle> triangles);

    /// A triangle that a straight motion goes through, if there is one.
    [[nodiscard]] std::optional<std::size_t> crossed(const Vector3 &from_m,
                                                     const Vector3 &to_m) const;

private:
    using Cell = Eigen::Array3i;

    [[nodiscard]] Cell cell_of(const Vector3 &point_m) const;
    [[nodiscard]] std::size_t index(int x, int y, int z) const;

    /// Calls `visit(index of a cell)` for the cells that a box overlaps.
    template <typename Visit>
    void for_each_cell(const Eigen::AlignedBox3d &box, const Visit &visit) const;

    /// The same for a triangle, without those that its plane does not meet.
    template <typename Visit>
    void for_each_cell(const PlainTriangle &triangle, const Visit &visit) const;

    std::span<const PlainTriangle> triangles_;
    Eigen::AlignedBox3d box_;
    double cell_m_ = 1.0;
    Cell cells_{Cell::Ones()};
    std::vector<std::uint32_t> first_; ///< of each cell in `entries_`; one more for the end
    std::vector<std::uint32_t> entries_;
};

} // namespace springdrive::rig

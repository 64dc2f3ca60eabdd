// Smooth shading made solid: a mesh bent into the surface that its normals describe.
//
// To turn only the force by interpolated normals, over flat facets, would give or take work along
// a closed path. So the surface itself is curved, and cut into facets too small to feel.
#pragma once

#include "base/vector.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace springdrive::scene {

/// Triangles with a normal at each vertex. Vertices may share a place, not a normal.
struct SmoothMesh {
    std::vector<Vector3> positions;
    std::vector<Vector3> normals; ///< unit, one a vertex
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// A cubic Bézier curve.
struct EdgeCurve {
    std::array<Vector3, 4> control;

    /// @param step of `steps`, from 0 at the start: a fraction of the way
    [[nodiscard]] Vector3 at(std::size_t step, std::size_t steps) const;
};

/// One curve for each edge, whichever of its triangles asks, so that patches meet without a crack.
/// Vertices that stand at the same place, to the last bit, count as one.
///
/// At either end the curve sets out within the tangent planes of the triangles there. Where these
/// are the same plane, up to 5°, that is the direction of a PN triangle's edge (Vlachos et al.
/// 2001, section 3.1); the length of its tangents is that of an arc of a circle, so that spheres
/// become round. Where they differ, the edge is sharp, and the curve follows the line in which they
/// meet: the rim of a cylinder becomes round, the edge of a cube stays straight.
class PatchEdges {
public:
    explicit PatchEdges(const SmoothMesh &mesh);

    struct Side {
        std::uint32_t curve; ///< index for `curve`
        bool backwards;      ///< the curve runs from the edge's end to its start
    };

    /// @param edge 0, 1 or 2: from that corner of the triangle to the next
    [[nodiscard]] Side side(std::size_t triangle, std::size_t edge) const {
        return sides_[3 * triangle + edge];
    }
    [[nodiscard]] const EdgeCurve &curve(const Side &side) const { return curves_[side.curve]; }

private:
    std::vector<Side> sides_;
    std::vector<EdgeCurve> curves_;
};

/// Each triangle of a mesh as a PN triangle: a cubic Bézier patch through its corners, square to
/// the normals there (A. Vlachos, J. Peters, C. Boyd, J. L. Mitchell, "Curved PN triangles",
/// I3D 2001). We depart from the paper in the lengths of tangents and along sharp edges (see
/// `PatchEdges`), and in the control point in the middle, so that patches meet without a ridge.
class CurvedPatches {
public:
    explicit CurvedPatches(SmoothMesh mesh);

    /// Into how many pieces each edge must be cut, for no two neighbouring facets of a patch to
    /// differ by more than `angle_rad`. At most `maximum`.
    [[nodiscard]] std::size_t cuts_for(double angle_rad, std::size_t maximum) const;

    /// The largest angle between neighbouring facets of one patch when edges are cut into `cuts`.
    [[nodiscard]] double max_turn_rad(std::size_t cuts) const;

    /// The patches of the triangles [first, last), each cut into cuts² facets. They come in the
    /// triangles' order, the vertices of each in that of `for_each_grid_point`.
    [[nodiscard]] SmoothMesh cut(std::size_t cuts, std::size_t first, std::size_t last) const;

private:
    struct Patch;
    [[nodiscard]] Patch patch(std::size_t triangle) const;
    [[nodiscard]] static Vector3 towards_even_joints(const Patch &patch);
    [[nodiscard]] double turn_rad(std::size_t triangle, std::size_t cuts) const;

    SmoothMesh mesh_;
    PatchEdges edges_;
};

/// Calls `visit(weights)` for the (cuts + 1)(cuts + 2)/2 vertices of a patch, with what each of
/// the three corners weighs there, all in pieces of 1/cuts.
void for_each_grid_point(std::size_t cuts,
                         const std::function<void(const std::array<std::size_t, 3> &)> &visit);

} // namespace springdrive::scene

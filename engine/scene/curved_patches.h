// Smooth shading made solid: a mesh bent into the surface that its normals describe.
//
// To turn only the force by interpolated normals, over flat facets, would give or take work along
// a closed path. So the surface itself is curved, and cut into facets too small to feel.
#pragma once

#include "engine/scene/patch_edges.h"

#include <cstddef>
#include <functional>

namespace springdrive::scene {

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

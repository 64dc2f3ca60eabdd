// The curves along which the curved patches of a mesh meet.
#pragma once

#include "base/vector.h"

#include <array>
#include <cstdint>
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

} // namespace springdrive::scene

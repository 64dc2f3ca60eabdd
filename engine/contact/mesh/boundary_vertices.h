// The vertices of a mesh that lie on its open edges.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/edge_table.h"
#include "engine/contact/mesh/mesh_triangle.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace springdrive::contact {

/// Numbers the ends of open edges from zero, in the order of the vertices.
class BoundaryVertices {
public:
    /// @param edges those of `triangles`
    BoundaryVertices(const std::vector<MeshTriangle> &triangles, const EdgeTable &edges,
                     const std::vector<Vector3> &vertices_m);

    [[nodiscard]] std::size_t size() const { return vertices_.size(); }
    [[nodiscard]] std::uint32_t vertex(std::uint32_t number) const { return vertices_[number]; }
    [[nodiscard]] const std::vector<Vector3> &places_m() const { return places_m_; }
    [[nodiscard]] const Vector3 &place_m(std::uint32_t number) const { return places_m_[number]; }

    [[nodiscard]] bool has(std::uint32_t vertex) const { return numbers_[vertex] != kNone; }
    [[nodiscard]] std::uint32_t number_of(std::uint32_t vertex) const { return numbers_[vertex]; }

    /// All triangles with the vertex as a corner, including those without an open edge.
    [[nodiscard]] std::span<const std::uint32_t> triangles_at(std::uint32_t number) const {
        return std::span(triangles_at_)
            .subspan(first_at_[number], first_at_[number + 1] - first_at_[number]);
    }

private:
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

    std::vector<std::uint32_t> numbers_; ///< of all vertices
    std::vector<std::uint32_t> vertices_;
    std::vector<Vector3> places_m_;
    std::vector<std::uint32_t> first_at_;
    std::vector<std::uint32_t> triangles_at_;
};

} // namespace springdrive::contact

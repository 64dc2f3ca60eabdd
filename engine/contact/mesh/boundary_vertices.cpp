#include "engine/contact/mesh/boundary_vertices.h"

#include <numeric>

namespace springdrive::contact {

BoundaryVertices::BoundaryVertices(const std::vector<MeshTriangle> &triangles,
                                   const EdgeTable &edges, const std::vector<Vector3> &vertices_m)
    : numbers_(vertices_m.size(), kNone) {
    edges.for_each([&](const Edge &edge) {
        if (edge.is_open()) {
            numbers_[edge.lower] = 0;
            numbers_[edge.upper()] = 0;
        }
    });
    for (std::uint32_t vertex = 0; vertex < numbers_.size(); ++vertex) {
        if (has(vertex)) {
            numbers_[vertex] = static_cast<std::uint32_t>(vertices_.size());
            vertices_.push_back(vertex);
            places_m_.push_back(vertices_m[vertex]);
        }
    }

    const auto for_each_corner = [&](auto visit) {
        for (std::uint32_t i = 0; i < triangles.size(); ++i) {
            for (const std::uint32_t corner : triangles[i].vertices) {
                if (has(corner)) {
                    visit(numbers_[corner], i);
                }
            }
        }
    };
    // A counting sort: filling a range moves its end down to its start.
    first_at_.assign(size() + 1, 0);
    for_each_corner([&](std::uint32_t number, std::uint32_t) { ++first_at_[number]; });
    std::partial_sum(first_at_.begin(), first_at_.end(), first_at_.begin());
    triangles_at_.resize(first_at_.back());
    for_each_corner([&](std::uint32_t number, std::uint32_t triangle) {
        triangles_at_[--first_at_[number]] = triangle;
    });
}

} // namespace springdrive::contact

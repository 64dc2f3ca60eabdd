// Meshes with the defects that exporters cause, and reference results about their edges.
#pragma once

#include "engine/contact/mesh/edge_table.h"
#include "engine/contact/mesh/mesh_preparation.h"
#include "engine/contact/mesh/mesh_triangle.h"
#include "tests/engine/contact/mesh/soups.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

namespace springdrive::testing {

inline std::vector<contact::MeshTriangle>
mesh_of(const std::vector<contact::VertexTriple> &triples) {
    std::vector<contact::MeshTriangle> triangles;
    triangles.reserve(triples.size());
    for (const contact::VertexTriple &triple : triples) {
        triangles.push_back({triple, static_cast<std::uint32_t>(triangles.size())});
    }
    return triangles;
}

inline contact::EdgeTable edges_of(const std::vector<contact::MeshTriangle> &triangles,
                                   unsigned threads = 1) {
    std::uint32_t vertices = 0;
    for (const contact::MeshTriangle &triangle : triangles) {
        vertices = std::max(vertices, std::ranges::max(triangle.vertices) + 1);
    }
    return {triangles, vertices, threads};
}

/// How often each edge is traversed from its lower vertex to its upper, and back.
template <typename Vertex>
std::map<std::pair<Vertex, Vertex>, std::array<int, 2>>
edge_counts(const std::vector<std::array<Vertex, 3>> &triangles) {
    std::map<std::pair<Vertex, Vertex>, std::array<int, 2>> counts;
    for (const std::array<Vertex, 3> &triangle : triangles) {
        for (std::size_t side = 0; side < 3; ++side) {
            const Vertex &from = triangle[side];
            const Vertex &to = triangle[(side + 1) % 3];
            ++(from < to ? counts[{from, to}][0] : counts[{to, from}][1]);
        }
    }
    return counts;
}

/// Whether every edge is traversed once in each direction: a closed manifold of consistent winding.
template <typename Vertex> bool is_watertight(const std::vector<std::array<Vertex, 3>> &triangles) {
    return std::ranges::all_of(edge_counts(triangles), [](const auto &edge) {
        return edge.second == std::array<int, 2>{1, 1};
    });
}

using Place = std::array<double, 3>;

inline Place place(const Vector3 &point_m) { return {point_m.x(), point_m.y(), point_m.z()}; }

/// Corners of facets as values that compare, the lowest first in each.
inline std::vector<std::array<Place, 3>> places(const std::vector<contact::FacetSource> &facets) {
    std::vector<std::array<Place, 3>> result;
    for (const contact::FacetSource &facet : facets) {
        std::array<Place, 3> corners = {place(facet.corners_m[0]), place(facet.corners_m[1]),
                                        place(facet.corners_m[2])};
        std::rotate(corners.begin(), std::ranges::min_element(corners), corners.end());
        result.push_back(corners);
    }
    return result;
}

inline double area_m2(const std::vector<contact::FacetSource> &facets) {
    double area = 0.0;
    for (const contact::FacetSource &facet : facets) {
        const auto &[a, b, c] = facet.corners_m;
        area += 0.5 * (b - a).cross(c - a).norm();
    }
    return area;
}

inline double volume_m3(const std::vector<contact::FacetSource> &facets) {
    double volume = 0.0;
    for (const contact::FacetSource &facet : facets) {
        const auto &[a, b, c] = facet.corners_m;
        volume += a.dot(b.cross(c)) / 6.0;
    }
    return volume;
}

/// The same triangles, each with vertices of its own.
inline contact::TriangleSoup unshared(const contact::TriangleSoup &soup) {
    contact::TriangleSoup result;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        add_triangle(result, corners(soup, i));
    }
    return result;
}

/// Every vertex moved at random, by up to `reach_m`.
inline contact::TriangleSoup shaken(contact::TriangleSoup soup, double reach_m,
                                    std::mt19937_64 &random) {
    std::uniform_real_distribution<double> share(0.0, 1.0);
    for (Vector3 &vertex : soup.vertices_m) {
        const double distance_m = reach_m * share(random);
        vertex += distance_m * random_direction(random);
    }
    return soup;
}

/// Vertices and triangles renumbered at random, the corners of each triangle begun anywhere.
inline contact::TriangleSoup shuffled(const contact::TriangleSoup &soup, std::mt19937_64 &random) {
    contact::TriangleSoup result = soup;
    std::vector<std::uint32_t> new_number(soup.vertices_m.size());
    for (std::uint32_t i = 0; i < new_number.size(); ++i) {
        new_number[i] = i;
    }
    std::ranges::shuffle(new_number, random);
    for (std::size_t i = 0; i < new_number.size(); ++i) {
        result.vertices_m[new_number[i]] = soup.vertices_m[i];
    }
    for (auto &triangle : result.triangles) {
        for (std::uint32_t &vertex : triangle) {
            vertex = new_number[vertex];
        }
        std::rotate(triangle.begin(), triangle.begin() + static_cast<int>(random() % 3),
                    triangle.end());
    }
    std::ranges::shuffle(result.triangles, random);
    return result;
}

/// Each triangle turned over with this probability.
inline contact::TriangleSoup partly_turned(contact::TriangleSoup soup, double probability,
                                           std::mt19937_64 &random) {
    std::bernoulli_distribution is_turned(probability);
    for (auto &triangle : soup.triangles) {
        if (is_turned(random)) {
            std::swap(triangle[0], triangle[2]);
        }
    }
    return soup;
}

/// A closed strip of `pairs` quadrilaterals with `half_turns`; a Möbius strip where these are odd.
inline std::vector<contact::VertexTriple> twisted_strip(std::uint32_t pairs,
                                                        std::uint32_t half_turns) {
    std::vector<contact::VertexTriple> triples;
    for (std::uint32_t i = 0; i < pairs; ++i) {
        const std::uint32_t a = 2 * i;
        const std::uint32_t b = 2 * i + 1;
        std::uint32_t c = 2 * ((i + 1) % pairs);
        std::uint32_t d = c + 1;
        if (i + 1 == pairs && half_turns % 2 == 1) {
            std::swap(c, d);
        }
        triples.push_back({a, b, d});
        triples.push_back({a, d, c});
    }
    return triples;
}

} // namespace springdrive::testing

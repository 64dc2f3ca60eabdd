// Triangle soups with known shapes, meshes with the defects that exporters cause, and slow
// reference results for comparison.
#pragma once

#include "engine/contact/mesh/mesh_preparation.h"
#include "engine/contact/mesh/triangle_soup.h"
#include "tests/support/configurations.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

namespace springdrive::testing {

using Corners = std::array<Vector3, 3>;

inline Corners corners(const contact::TriangleSoup &soup, std::size_t triangle) {
    const auto &[a, b, c] = soup.triangles[triangle];
    return {soup.vertices_m[a], soup.vertices_m[b], soup.vertices_m[c]};
}

inline void add_triangle(contact::TriangleSoup &soup, const Corners &triangle) {
    const auto first = static_cast<std::uint32_t>(soup.vertices_m.size());
    soup.vertices_m.insert(soup.vertices_m.end(), triangle.begin(), triangle.end());
    soup.triangles.push_back({first, first + 1, first + 2});
    soup.material_of_triangle.push_back(0);
    if (soup.materials.empty()) {
        soup.materials.push_back({"test", 0.0});
    }
}

/// An icosahedron, each triangle divided into four `level` times, on a sphere about the origin:
/// 20 · 4^level triangles that share their vertices.
inline contact::TriangleSoup icosphere(int level, double radius_m) {
    contact::TriangleSoup soup;
    const double g = 0.5 * (1.0 + std::sqrt(5.0));
    soup.vertices_m = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                       {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    soup.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                      {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                      {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                      {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    for (int i = 0; i < level; ++i) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [found, is_new] =
                middles.try_emplace(std::minmax(a, b), soup.vertices_m.size());
            if (is_new) {
                const Vector3 point = 0.5 * (soup.vertices_m[a] + soup.vertices_m[b]);
                soup.vertices_m.push_back(point);
            }
            return found->second;
        };
        std::vector<std::array<std::uint32_t, 3>> finer;
        for (const auto &[a, b, c] : soup.triangles) {
            const std::uint32_t ab = middle(a, b);
            const std::uint32_t bc = middle(b, c);
            const std::uint32_t ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
        }
        soup.triangles = std::move(finer);
        for (Vector3 &vertex : soup.vertices_m) {
            vertex.normalize();
        }
    }
    for (Vector3 &vertex : soup.vertices_m) {
        vertex = radius_m * vertex.normalized();
    }
    soup.material_of_triangle.assign(soup.triangles.size(), 0);
    soup.materials = {{"sphere", 0.0}};
    return soup;
}

/// A closed shape with hills, valleys and saddles: an icosphere with waves of its radius.
inline contact::TriangleSoup bumpy_sphere(int level, double radius_m) {
    contact::TriangleSoup soup = icosphere(level, radius_m);
    for (Vector3 &vertex : soup.vertices_m) {
        const Vector3 u = vertex.normalized();
        vertex *= 1.0 + 0.15 * std::sin(7.0 * u.x()) * std::cos(6.0 * u.y()) +
                  0.1 * std::sin(9.0 * u.z() + 1.0);
    }
    return soup;
}

/// A closed solid from rings of points about the y axis, from bottom to top, each given as (radius,
/// height); the first and the last may be points.
inline contact::TriangleSoup lathed(const std::vector<std::pair<double, double>> &rings,
                                    int around) {
    contact::TriangleSoup soup;
    const auto point = [&](std::size_t ring, int i) {
        const double angle = 6.28318530717958647692 * (i % around) / around;
        const auto [radius, height] = rings[ring];
        return Vector3(radius * std::sin(angle), height, radius * std::cos(angle));
    };
    for (std::size_t ring = 0; ring + 1 < rings.size(); ++ring) {
        for (int i = 0; i < around; ++i) {
            if (rings[ring].first > 0.0) {
                add_triangle(soup, {point(ring, i), point(ring, i + 1), point(ring + 1, i)});
            }
            if (rings[ring + 1].first > 0.0) {
                add_triangle(soup,
                             {point(ring, i + 1), point(ring + 1, i + 1), point(ring + 1, i)});
            }
        }
    }
    return soup;
}

/// A cone of 5 mm at the foot and 40 mm long, point up, of 24 sides.
inline contact::TriangleSoup needle() {
    return lathed({{0.0, -0.02}, {0.005, -0.02}, {0.0, 0.02}}, 24);
}

/// Half a hollow ball of 30 mm, open to the top, its wall 1 mm.
inline contact::TriangleSoup bowl(int rings) {
    std::vector<std::pair<double, double>> profile;
    const auto at = [&](double radius, int i) {
        const double angle = 0.5 * 3.14159265358979323846 * i / rings;
        return std::pair(i == 0 ? 0.0 : radius * std::sin(angle), -radius * std::cos(angle));
    };
    for (int i = 0; i <= rings; ++i) {
        profile.push_back(at(0.030, i));
    }
    for (int i = rings; i >= 0; --i) {
        profile.push_back(at(0.029, i));
    }
    return lathed(profile, 4 * rings);
}

/// A wedge of two degrees, edge up, 60 mm long and 40 mm high.
inline contact::TriangleSoup knife() {
    const double half = 0.04 * std::tan(0.01745);
    contact::TriangleSoup soup;
    soup.vertices_m = {{-half, -0.02, -0.03}, {half, -0.02, -0.03}, {0.0, 0.02, -0.03},
                       {-half, -0.02, 0.03},  {half, -0.02, 0.03},  {0.0, 0.02, 0.03}};
    soup.triangles = {{0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3},
                      {1, 2, 5}, {1, 5, 4}, {0, 3, 5}, {0, 5, 2}};
    soup.material_of_triangle.assign(soup.triangles.size(), 0);
    soup.materials = {{"knife", 0.0}};
    return soup;
}

/// A square sheet in the plane y = 0, facing up, from -half to +half, in `cells` × `cells` pairs.
inline contact::TriangleSoup sheet(int cells, double half_m) {
    contact::TriangleSoup soup;
    for (int i = 0; i < cells; ++i) {
        for (int j = 0; j < cells; ++j) {
            const auto at = [&](int di, int dj) {
                return Vector3(half_m * (2.0 * (i + di) / cells - 1.0), 0.0,
                               half_m * (2.0 * (j + dj) / cells - 1.0));
            };
            add_triangle(soup, {at(0, 0), at(0, 1), at(1, 1)});
            add_triangle(soup, {at(0, 0), at(1, 1), at(1, 0)});
        }
    }
    return soup;
}

/// Triangles about the origin, each between two neighbours of a closed rim.
inline contact::TriangleSoup closed_fan(const std::vector<Vector3> &rim_m) {
    contact::TriangleSoup soup;
    soup.vertices_m = {Vector3::Zero()};
    soup.vertices_m.insert(soup.vertices_m.end(), rim_m.begin(), rim_m.end());
    const auto count = static_cast<std::uint32_t>(rim_m.size());
    for (std::uint32_t i = 0; i < count; ++i) {
        soup.triangles.push_back({0, 1 + (i + 1) % count, 1 + i});
    }
    soup.material_of_triangle.assign(count, 0);
    soup.materials = {{"fan", 0.0}};
    return soup;
}

inline contact::TriangleSoup turned_inside_out(contact::TriangleSoup soup) {
    for (auto &triangle : soup.triangles) {
        std::swap(triangle[1], triangle[2]);
    }
    return soup;
}

inline contact::TriangleSoup moved(contact::TriangleSoup soup, const Eigen::Isometry3d &motion) {
    for (Vector3 &vertex : soup.vertices_m) {
        vertex = motion * vertex;
    }
    return soup;
}

inline contact::TriangleSoup joined(contact::TriangleSoup soup,
                                    const contact::TriangleSoup &other) {
    const auto first_vertex = static_cast<std::uint32_t>(soup.vertices_m.size());
    const auto first_material = static_cast<std::uint16_t>(soup.materials.size());
    soup.vertices_m.insert(soup.vertices_m.end(), other.vertices_m.begin(), other.vertices_m.end());
    for (const auto &[a, b, c] : other.triangles) {
        soup.triangles.push_back({first_vertex + a, first_vertex + b, first_vertex + c});
    }
    for (const std::uint16_t material : other.material_of_triangle) {
        soup.material_of_triangle.push_back(static_cast<std::uint16_t>(first_material + material));
    }
    soup.materials.insert(soup.materials.end(), other.materials.begin(), other.materials.end());
    return soup;
}

inline contact::TriangleSoup random_soup(std::mt19937_64 &random, int triangles, double half_m,
                                         double size_m) {
    contact::TriangleSoup soup;
    for (int i = 0; i < triangles; ++i) {
        const Vector3 centre = random_vector(random, half_m);
        const Vector3 a = centre + random_vector(random, size_m);
        const Vector3 b = centre + random_vector(random, size_m);
        const Vector3 c = centre + random_vector(random, size_m);
        add_triangle(soup, {a, b, c});
    }
    return soup;
}

/// Triangles with corners anywhere in a box about the origin.
inline contact::TriangleSoup scattered_soup(std::mt19937_64 &random, int triangles,
                                            const Vector3 &half_m) {
    contact::TriangleSoup soup;
    for (int i = 0; i < triangles; ++i) {
        Corners triangle;
        for (Vector3 &corner : triangle) {
            corner = random_vector(random, 1.0).cwiseProduct(half_m);
        }
        add_triangle(soup, triangle);
    }
    return soup;
}

/// Triangles 10 cm long, in a line a few micrometres thick: the most work for preparation.
inline contact::TriangleSoup soup_in_a_line(std::mt19937_64 &random, int triangles) {
    return scattered_soup(random, triangles, {0.05, 3e-6, 3e-6});
}

/// How often a closed surface winds about a point: 1 inside, 0 outside. By the solid angles of
/// its triangles (van Oosterom and Strackee 1983).
inline double winding_number(const contact::TriangleSoup &soup, const Vector3 &point_m) {
    double solid_angle = 0.0;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        auto [a, b, c] = corners(soup, i);
        a -= point_m;
        b -= point_m;
        c -= point_m;
        solid_angle += 2.0 * std::atan2(a.dot(b.cross(c)),
                                        a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                                            b.dot(c) * a.norm() + c.dot(a) * b.norm());
    }
    return solid_angle / (4.0 * 3.14159265358979323846);
}

/// Barycentric coordinates of a point's foot on the plane of a triangle.
inline Vector3 foot_coordinates(const Corners &triangle, const Vector3 &point_m) {
    const Vector3 e1 = triangle[1] - triangle[0];
    const Vector3 e2 = triangle[2] - triangle[0];
    const Vector3 n = e1.cross(e2);
    const Vector3 r = point_m - triangle[0];
    const double b = r.cross(e2).dot(n) / n.squaredNorm();
    const double c = e1.cross(r).dot(n) / n.squaredNorm();
    return {1.0 - b - c, b, c};
}

inline double distance_to_segment(const Vector3 &p, const Vector3 &a, const Vector3 &b) {
    const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    return (p - a - t * (b - a)).norm();
}

inline double distance_to_triangle(const Corners &triangle, const Vector3 &point_m) {
    if (foot_coordinates(triangle, point_m).minCoeff() >= 0.0) {
        const Vector3 n = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).normalized();
        return std::abs(n.dot(point_m - triangle[0]));
    }
    return std::min({distance_to_segment(point_m, triangle[0], triangle[1]),
                     distance_to_segment(point_m, triangle[1], triangle[2]),
                     distance_to_segment(point_m, triangle[2], triangle[0])});
}

inline double distance_to_soup(const contact::TriangleSoup &soup, const Vector3 &point_m) {
    double minimum = INFINITY;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        minimum = std::min(minimum, distance_to_triangle(corners(soup, i), point_m));
    }
    return minimum;
}

inline std::vector<contact::MeshTriangle>
mesh_of(const std::vector<contact::VertexTriple> &triples) {
    std::vector<contact::MeshTriangle> triangles;
    triangles.reserve(triples.size());
    for (const contact::VertexTriple &triple : triples) {
        triangles.push_back({triple, static_cast<std::uint32_t>(triangles.size())});
    }
    return triangles;
}

inline contact::EdgeTable edges_of(const std::vector<contact::MeshTriangle> &triangles) {
    std::uint32_t vertices = 0;
    for (const contact::MeshTriangle &triangle : triangles) {
        vertices = std::max(vertices, std::ranges::max(triangle.vertices) + 1);
    }
    return {triangles, vertices, 1};
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

using PlaceKey = std::array<double, 3>;

inline PlaceKey place_key(const Vector3 &point_m) {
    return {point_m.x(), point_m.y(), point_m.z()};
}

/// Corners of facets as values that compare, the lowest first in each.
inline std::vector<std::array<PlaceKey, 3>>
place_keys(const std::vector<contact::FacetSource> &facets) {
    std::vector<std::array<PlaceKey, 3>> result;
    for (const contact::FacetSource &facet : facets) {
        std::array<PlaceKey, 3> corners = {place_key(facet.corners_m[0]),
                                           place_key(facet.corners_m[1]),
                                           place_key(facet.corners_m[2])};
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

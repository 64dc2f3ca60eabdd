// Measures of generated surfaces.
#pragma once

#include "engine/contact/mesh/triangle_soup.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace springdrive::testing {

/// How edges are shared, where vertices are.
struct EdgeUse {
    std::size_t paired = 0; ///< run through once each way: two triangles wound alike
    std::size_t open = 0;   ///< of one triangle
    std::size_t other = 0;
};

inline EdgeUse edge_use(const contact::TriangleSoup &soup) {
    // The ends, the lower first, and 1 where they are run through in this order.
    std::vector<std::array<std::uint32_t, 3>> edges;
    edges.reserve(3 * soup.triangles.size());
    for (const auto &t : soup.triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [lower, upper] = std::minmax(t[i], t[(i + 1) % 3]);
            edges.push_back({lower, upper, lower == t[i] ? 1U : 0U});
        }
    }
    std::ranges::sort(edges);
    EdgeUse use;
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t end = i + 1;
        while (end < edges.size() && edges[end][0] == edges[i][0] && edges[end][1] == edges[i][1]) {
            ++end;
        }
        const bool is_pair = end == i + 2 && edges[i][2] != edges[i + 1][2];
        ++(end == i + 1 ? use.open : is_pair ? use.paired : use.other);
        i = end;
    }
    return use;
}

/// Every edge is run through once each way: closed, and wound alike all over.
inline bool is_closed(const contact::TriangleSoup &soup) {
    const EdgeUse use = edge_use(soup);
    return use.open == 0 && use.other == 0;
}

inline double volume_m3(const contact::TriangleSoup &soup) {
    double sum = 0.0;
    for (const auto &[a, b, c] : soup.triangles) {
        sum += soup.vertices_m[a].cross(soup.vertices_m[b]).dot(soup.vertices_m[c]);
    }
    return sum / 6.0;
}

/// The longest edge over the height on it.
inline double slenderness(const contact::TriangleSoup &soup, std::size_t triangle) {
    const auto &[a, b, c] = soup.triangles[triangle];
    const Vector3 to_b = soup.vertices_m[b] - soup.vertices_m[a];
    const Vector3 to_c = soup.vertices_m[c] - soup.vertices_m[a];
    const double longest_squared =
        std::max({to_b.squaredNorm(), to_c.squaredNorm(), (to_c - to_b).squaredNorm()});
    return longest_squared / to_b.cross(to_c).norm();
}

} // namespace springdrive::testing

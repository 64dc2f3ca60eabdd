// Disjoint sets of triangles with the relative winding of their members.
#pragma once

#include "base/assertions.h"
#include "engine/contact/mesh/mesh_triangle.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace springdrive::contact {

/// Union-find with path halving; each link stores whether its two ends are wound oppositely. The
/// root of a set is its first triangle.
class TriangleSets {
public:
    struct Place {
        std::uint32_t root = 0;
        bool is_opposite = false; ///< wound opposite to the root
    };

    /// @pre at most kMaxTriangles
    explicit TriangleSets(std::size_t count) : link_(count) {
        SPRINGDRIVE_ASSERT(count <= kMaxTriangles);
        for (std::uint32_t triangle = 0; triangle < count; ++triangle) {
            link_[triangle] = triangle << 1;
        }
    }

    [[nodiscard]] Place place_of(std::uint32_t triangle) {
        std::uint32_t parity = 0;
        while (link_[triangle] >> 1 != triangle) {
            const std::uint32_t parent = link_[triangle];
            link_[triangle] = link_[parent >> 1] ^ (parent & 1U);
            parity ^= link_[triangle] & 1U;
            triangle = link_[triangle] >> 1;
        }
        return {triangle, parity != 0};
    }

    [[nodiscard]] std::uint32_t root_of(std::uint32_t triangle) { return place_of(triangle).root; }

    /// False if both are already in one set with the other relative winding.
    bool unite(std::uint32_t a, std::uint32_t b, bool are_opposite) {
        const Place at = place_of(a);
        const Place bt = place_of(b);
        const bool is_odd = at.is_opposite != bt.is_opposite;
        if (at.root == bt.root) {
            return is_odd == are_opposite;
        }
        link_[std::max(at.root, bt.root)] =
            std::min(at.root, bt.root) << 1 | std::uint32_t{is_odd != are_opposite};
        return true;
    }

private:
    std::vector<std::uint32_t> link_; ///< parent · 2 + parity
};

} // namespace springdrive::contact

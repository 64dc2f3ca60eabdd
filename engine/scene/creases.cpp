#include "engine/scene/creases.h"

#include "base/cancellation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <utility>

namespace springdrive::scene {

namespace {

using Point = std::array<float, 3>;

/// An edge as one of its triangles has it, from the smaller point to the larger.
struct EdgeSide {
    std::array<Point, 2> ends;
    std::array<Point, 2> normals;
};

bool takes_lines(const VisualMesh &mesh) {
    return mesh.texture < 0 && mesh.finish.normal_texture < 0 && !mesh.translucent &&
           !mesh.alpha_cutoff;
}

void add_sides(const VisualMesh &mesh, std::vector<EdgeSide> &sides) {
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        stop_if_given_up(i);
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const VisualVertex *from = &mesh.vertices[mesh.indices[i + corner]];
            const VisualVertex *to = &mesh.vertices[mesh.indices[i + (corner + 1) % 3]];
            if (to->position_m < from->position_m) {
                std::swap(from, to);
            }
            if (from->position_m != to->position_m) {
                sides.push_back({{from->position_m, to->position_m}, {from->normal, to->normal}});
            }
        }
    }
}

bool turns(const Point &normal, const Point &other) {
    static const double kMin = std::cos(kCrease_deg * std::numbers::pi / 180.0);
    return std::inner_product(normal.begin(), normal.end(), other.begin(), 0.0) < kMin;
}

/// @param sides of one edge
bool is_crease(std::span<const EdgeSide> sides) {
    return sides.size() == 1 || std::ranges::any_of(sides.subspan(1), [&](const EdgeSide &side) {
               return turns(side.normals[0], sides.front().normals[0]) ||
                      turns(side.normals[1], sides.front().normals[1]);
           });
}

} // namespace

std::vector<LineSegment> creases_of(std::span<const VisualMesh> meshes) {
    std::vector<EdgeSide> sides;
    for (const VisualMesh &mesh : meshes) {
        if (takes_lines(mesh)) {
            add_sides(mesh, sides);
        }
        if (sides.size() > 3 * kMaxCreasedTriangles) {
            return {};
        }
    }
    std::ranges::sort(sides, {}, &EdgeSide::ends);
    std::vector<LineSegment> creases;
    for (auto begin = sides.begin(); begin != sides.end();) {
        const auto end = std::find_if(
            begin, sides.end(), [&](const EdgeSide &side) { return side.ends != begin->ends; });
        if (is_crease({begin, end})) {
            creases.push_back(begin->ends);
        }
        if (creases.size() > kMaxCreases) {
            return {};
        }
        begin = end;
    }
    return creases;
}

} // namespace springdrive::scene

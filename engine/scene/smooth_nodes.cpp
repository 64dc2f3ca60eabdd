#include "engine/scene/gltf_mesh.h"

#include "base/degrees.h"
#include "base/input_error.h"
#include "base/text.h"
#include "engine/scene/curved_patches.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace springdrive::scene::gltf {

namespace {

constexpr std::size_t kMaxCuts = 128; // of an edge; more is asked for by damaged normals only

/// The primitives of one smooth node and their patches.
struct SmoothNode {
    std::span<PlacedPrimitive> primitives;
    CurvedPatches patches;
    std::size_t triangles;
    std::size_t wanted_cuts;
    std::size_t cuts;
};

/// All primitives as one mesh, in world coordinates.
SmoothMesh joined(std::span<const PlacedPrimitive> primitives) {
    SmoothMesh mesh;
    for (const PlacedPrimitive &primitive : primitives) {
        const std::string &label = primitive.node->label;
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (std::size_t i = 0; i < primitive.positions.size(); ++i) {
            mesh.positions.push_back(primitive.positions[i]);
            mesh.normals.push_back(world_normal(primitive, i).stableNormalized());
            if (!(std::abs(mesh.normals.back().norm() - 1.0) < 0.5)) {
                throw InputError(label + ": extras.smooth needs normals, but that of vertex " +
                                 std::to_string(i) + " has no direction; export it again");
            }
        }
        for (const auto &[a, b, c] : primitive.geometry->triangles) {
            mesh.triangles.push_back({first + a, first + b, first + c});
        }
    }
    return mesh;
}

/// A vertex attribute at the vertices of the divided patches.
Attribute interpolated(const Attribute &coarse, const std::vector<Triangle> &triangles,
                       std::size_t cuts) {
    Attribute fine{coarse.components, {}};
    if (coarse.empty()) {
        return fine;
    }
    for (const Triangle &triangle : triangles) {
        for_each_grid_point(cuts, [&](const std::array<std::size_t, 3> &weights) {
            for (std::size_t c = 0; c < static_cast<std::size_t>(coarse.components); ++c) {
                double sum = 0.0;
                for (std::size_t corner = 0; corner < 3; ++corner) {
                    sum += static_cast<double>(weights[corner]) * coarse[triangle[corner]][c];
                }
                fine.values.push_back(sum / static_cast<double>(cuts));
            }
        });
    }
    return fine;
}

/// @param first  index of the first patch of the primitive
void bend(PlacedPrimitive &primitive, const CurvedPatches &patches, std::size_t first,
          std::size_t cuts) {
    const PrimitiveGeometry &coarse = *primitive.geometry;
    SmoothMesh curved = patches.cut(cuts, first, first + coarse.triangles.size());
    PrimitiveGeometry fine;
    fine.colour = interpolated(coarse.colour, coarse.triangles, cuts);
    fine.texture_coordinate = interpolated(coarse.texture_coordinate, coarse.triangles, cuts);
    fine.triangles = std::move(curved.triangles);
    primitive.geometry = std::make_shared<const PrimitiveGeometry>(std::move(fine));
    primitive.positions = std::move(curved.positions);
    primitive.normals = std::move(curved.normals);
}

void bend(const SmoothNode &node) {
    std::size_t first = 0;
    for (PlacedPrimitive &primitive : node.primitives) {
        const std::size_t count = primitive.geometry->triangles.size();
        bend(primitive, node.patches, first, node.cuts);
        first += count;
    }
}

std::size_t triangles_of(std::span<const PlacedPrimitive> primitives) {
    std::size_t triangles = 0;
    for (const PlacedPrimitive &primitive : primitives) {
        triangles += primitive.geometry->triangles.size();
    }
    return triangles;
}

bool have_normals(std::span<const PlacedPrimitive> primitives) {
    return std::ranges::none_of(primitives, [](const PlacedPrimitive &primitive) {
        return primitive.geometry->normal.empty();
    });
}

/// The smooth primitives, except those without normals and those with too many triangles to be
/// divided even once.
std::vector<SmoothNode> find_smooth_nodes(std::vector<PlacedPrimitive> &primitives,
                                          WarningList &warnings) {
    std::vector<SmoothNode> nodes;
    for (std::span rest(primitives); !rest.empty();) {
        const std::span those = rest.first(first_node_size(rest));
        rest = rest.subspan(those.size());
        const PlacedMesh *const node = those.front().node;
        const std::size_t triangles = triangles_of(those);
        if (!node->touch.smooth) {
            continue;
        }
        if (4 * triangles > kMaxCurvedTriangles) {
            warnings.add_of(node->label, node,
                            "is too large to be smoothed further; its " +
                                std::to_string(triangles) + " triangles stay flat");
            continue;
        }
        if (!have_normals(those)) {
            warnings.add_of(node->label, node,
                            "extras.smooth is left out: it needs normals; export it with them");
            continue;
        }
        CurvedPatches patches(joined(those));
        const std::size_t cuts = patches.cuts_for(kSmooth_deg / kDegreesPerRadian, kMaxCuts);
        nodes.push_back({those, std::move(patches), triangles, cuts, cuts});
    }
    return nodes;
}

/// Coarser division of all, where there would be too many triangles.
void keep_within_allowance(std::vector<SmoothNode> &nodes) {
    double wanted = 0.0;
    for (const SmoothNode &node : nodes) {
        wanted += static_cast<double>(node.triangles * node.cuts * node.cuts);
    }
    const double share = std::sqrt(static_cast<double>(kMaxCurvedTriangles) / wanted);
    for (SmoothNode &node : nodes) {
        const double cuts = std::floor(share * static_cast<double>(node.cuts));
        node.cuts = std::clamp<std::size_t>(static_cast<std::size_t>(cuts), 1, node.cuts);
    }
}

void warn_about(const SmoothNode &node, WarningList &warnings) {
    if (node.cuts == node.wanted_cuts && node.cuts < kMaxCuts) {
        return; // as smooth as it should be
    }
    const double turn_deg =
        node.patches.max_turn_rad(std::max<std::size_t>(node.cuts, 2)) * kDegreesPerRadian;
    const double reached_deg = node.cuts == 1 ? 2.0 * turn_deg : turn_deg;
    if (reached_deg > kSmooth_deg) {
        const PlacedMesh *const place = node.primitives.front().node;
        warnings.add_of(place->label, place,
                        "its " + std::to_string(node.triangles * node.cuts * node.cuts) +
                            " curved facets still differ by up to " +
                            shortest_text(std::round(100.0 * reached_deg) / 100.0) +
                            " degrees from their neighbours, instead of " +
                            shortest_text(kSmooth_deg));
    }
}

} // namespace

void bend_smooth_nodes(std::vector<PlacedPrimitive> &primitives, WarningList &warnings) {
    std::vector<SmoothNode> nodes = find_smooth_nodes(primitives, warnings);
    keep_within_allowance(nodes);
    for (const SmoothNode &node : nodes) {
        warn_about(node, warnings);
        if (node.cuts > 1) {
            bend(node);
        }
    }
}

} // namespace springdrive::scene::gltf

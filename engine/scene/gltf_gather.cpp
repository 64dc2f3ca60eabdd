#include "engine/scene/gltf_gather.h"

#include "base/input_error.h"
#include "base/wanted.h"
#include "engine/scene/load_allowance.h"
#include "engine/scene/smooth_nodes.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <limits>
#include <optional>

namespace springdrive::scene::gltf {

namespace {

struct PrimitiveData {
    std::shared_ptr<const PrimitiveGeometry> geometry;
    BaseColour colour;
};

/// Each mesh's primitives, read when first placed.
class MeshCache {
public:
    explicit MeshCache(const tinygltf::Model &model)
        : model_(model), meshes_(model.meshes.size()) {}

    const std::vector<PrimitiveData> &primitives(int mesh) {
        const auto index = static_cast<std::size_t>(mesh);
        std::optional<std::vector<PrimitiveData>> &entry = meshes_[index];
        if (!entry) {
            entry.emplace();
            for (const tinygltf::Primitive &primitive : model_.meshes[index].primitives) {
                const BaseColour colour = read_base_colour(model_, primitive.material);
                entry->push_back({std::make_shared<const PrimitiveGeometry>(
                                      read_primitive(model_, primitive, colour.texture_set)),
                                  colour});
            }
        }
        return *entry;
    }

private:
    const tinygltf::Model &model_;
    std::vector<std::optional<std::vector<PrimitiveData>>> meshes_;
};

void remark_on(const PlacedMesh &node, const PrimitiveGeometry &geometry,
               std::vector<std::string> &remarks) {
    if (!geometry.untouchable.empty()) {
        remarks.push_back(node.label + ": " + geometry.untouchable + " cannot be touched or drawn");
    }
    if (geometry.leftover_vertices > 0) {
        remarks.push_back(node.label + ": " + std::to_string(geometry.leftover_vertices) +
                          " vertices are left over and make no triangle");
    }
    if (geometry.has_morph_targets) {
        remarks.push_back(node.label + ": its morph targets are left out; it is touched and drawn "
                                       "in its base shape");
    }
}

std::vector<Vector3> world_positions(const PlacedMesh &node, const PrimitiveGeometry &geometry) {
    std::vector<Vector3> positions(geometry.position.count());
    for (std::size_t i = 0; i < positions.size(); ++i) {
        stop_if_given_up(i);
        positions[i] = node.to_world * Vector3(geometry.position[i].data());
        if (!positions[i].allFinite()) {
            throw InputError(node.label + ": its transform takes vertex " + std::to_string(i) +
                             " out of the finite");
        }
    }
    return positions;
}

BoundingBox used_box(const PrimitiveGeometry &geometry) {
    BoundingBox box;
    for (const Triangle &triangle : geometry.triangles) {
        for (const std::uint32_t corner : triangle) {
            box.include(Vector3(geometry.position[corner].data()));
        }
    }
    return box;
}

/// Runs `step` for each node; what it throws gets the node's label in front.
template <typename Step> void for_each_node(const std::vector<PlacedMesh> &nodes, Step &&step) {
    for (const PlacedMesh &node : nodes) {
        try {
            step(node);
        } catch (const InputError &error) {
            const std::string what = error.what();
            throw InputError(what.starts_with(node.label) ? what : node.label + ": " + what);
        }
    }
}

/// Adds what the file says of a primitive, so that nothing has to be read to refuse it.
void add_declared(const tinygltf::Model &model, const tinygltf::Primitive &primitive,
                  LoadAllowance &allowance) {
    const auto position = primitive.attributes.find("POSITION");
    const bool is_drawn_by_line =
        primitive.mode >= TINYGLTF_MODE_POINTS && primitive.mode < TINYGLTF_MODE_TRIANGLES;
    if (position == primitive.attributes.end() || is_drawn_by_line) {
        return;
    }
    const std::size_t vertices = accessor_count(model, position->second);
    const std::size_t corners =
        primitive.indices >= 0 ? accessor_count(model, primitive.indices) : vertices;
    constexpr std::size_t kTooMany = std::numeric_limits<std::size_t>::max() / 4; // sums must hold
    allowance.add(
        std::min(primitive.mode == TINYGLTF_MODE_TRIANGLES ? corners / 3 : corners, kTooMany),
        std::min(vertices, kTooMany));
}

void check_declared(const tinygltf::Model &model, const std::vector<PlacedMesh> &nodes) {
    LoadAllowance allowance;
    if (std::ranges::any_of(nodes, [](const PlacedMesh &node) { return node.touch.smooth; })) {
        allowance.add(kMostCurvedTriangles, kMostCurvedTriangles);
    }
    for_each_node(nodes, [&](const PlacedMesh &node) {
        for (const auto &primitive : model.meshes[static_cast<std::size_t>(node.mesh)].primitives) {
            add_declared(model, primitive, allowance);
        }
    });
}

} // namespace

std::vector<PlacedPrimitive> gather(const tinygltf::Model &model,
                                    const std::vector<PlacedMesh> &nodes,
                                    std::vector<std::string> &remarks, LoadProgress &progress) {
    check_declared(model, nodes);
    std::vector<PlacedPrimitive> gathered;
    MeshCache cache(model);
    LoadAllowance allowance; // of what is there indeed: compressed data may hold more than declared
    std::size_t done = 0;
    for_each_node(nodes, [&](const PlacedMesh &node) {
        if (node.has_skin) {
            remarks.push_back(node.label + ": its skin is left out; it is touched and drawn in the "
                                           "pose that it was modelled in");
        }
        for (const PrimitiveData &primitive : cache.primitives(node.mesh)) {
            stop_if_given_up();
            const PrimitiveGeometry &geometry = *primitive.geometry;
            remark_on(node, geometry, remarks);
            if (!geometry.triangles.empty()) {
                allowance.add(geometry.triangles.size(), geometry.position.count());
                gathered.push_back({&node,
                                    primitive.geometry,
                                    primitive.colour,
                                    used_box(geometry),
                                    world_positions(node, geometry),
                                    {}});
            }
        }
        progress.advance_to(static_cast<double>(++done) / static_cast<double>(nodes.size()));
    });
    return gathered;
}

} // namespace springdrive::scene::gltf

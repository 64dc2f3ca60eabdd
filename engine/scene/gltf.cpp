#include "engine/scene/gltf.h"

#include "base/input_error.h"
#include "engine/scene/fit.h"
#include "engine/scene/gltf_file.h"
#include "engine/scene/gltf_material.h"
#include "engine/scene/gltf_mesh.h"
#include "engine/scene/gltf_nodes.h"
#include "engine/scene/gltf_primitive.h"
#include "engine/scene/gltf_text.h"

#include <tiny_gltf.h>

#include <limits>
#include <new>
#include <optional>

namespace springdrive {

namespace {

using namespace gltf;

constexpr std::size_t kMostTriangles = 20'000'000;
constexpr double kFarthest_m = 1000.0; // beyond this, "metres" must be a mistake

struct PrimitiveData {
    PrimitiveGeometry geometry;
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
                entry->push_back({read_primitive(model_, primitive, colour.texture_set), colour});
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
        positions[i] = node.to_world * Vector3(geometry.position[i].data());
        if (!positions[i].allFinite()) {
            throw InputError(node.label + ": its transform takes vertex " + std::to_string(i) +
                             " out of the finite");
        }
    }
    return positions;
}

/// Everything that has triangles, in the file's own world coordinates.
std::vector<PlacedPrimitive> gather(const std::vector<PlacedMesh> &nodes, MeshCache &cache,
                                    std::vector<std::string> &remarks) {
    std::vector<PlacedPrimitive> gathered;
    std::size_t triangles = 0;
    std::size_t vertices = 0;
    for (const PlacedMesh &node : nodes) {
        if (node.has_skin) {
            remarks.push_back(node.label + ": its skin is left out; it is touched and drawn in the "
                                           "pose that it was modelled in");
        }
        try {
            for (const PrimitiveData &primitive : cache.primitives(node.mesh)) {
                remark_on(node, primitive.geometry, remarks);
                if (primitive.geometry.triangles.empty()) {
                    continue;
                }
                triangles += primitive.geometry.triangles.size();
                vertices += primitive.geometry.position.count();
                if (triangles > kMostTriangles || vertices > kMostVertices) {
                    throw InputError("with it the scene has more than " +
                                     std::to_string(kMostTriangles) + " triangles or " +
                                     std::to_string(kMostVertices) + " vertices; simplify it");
                }
                gathered.push_back({&node, &primitive.geometry, &primitive.colour,
                                    world_positions(node, primitive.geometry)});
            }
        } catch (const InputError &error) {
            const std::string what = error.what();
            throw InputError(what.starts_with(node.label) ? what : node.label + ": " + what);
        }
    }
    return gathered;
}

BoundingBox bounds_of(const std::vector<PlacedPrimitive> &primitives) {
    BoundingBox box;
    for (const PlacedPrimitive &primitive : primitives) {
        for (const Triangle &triangle : primitive.geometry->triangles) {
            for (const std::uint32_t corner : triangle) {
                box.include(primitive.positions[corner]);
            }
        }
    }
    return box;
}

/// Puts everything where it belongs in the device's frame.
void fit_scene(Scene &scene, std::vector<PlacedPrimitive> &primitives, const Workspace &workspace) {
    BoundingBox box = bounds_of(primitives);
    const Fit fit = fit_into(workspace, box); // also refuses what has no extent
    if (!scene.in_metres) {
        for (PlacedPrimitive &primitive : primitives) {
            for (Vector3 &position : primitive.positions) {
                position = fit(position);
            }
        }
        scene.metres_per_unit = fit.scale;
        box = bounds_of(primitives);
    } else if (const double reach_m = std::max(-box.lower.minCoeff(), box.upper.maxCoeff());
               reach_m > kFarthest_m) {
        throw InputError("it says that it is in metres, but reaches " + shortest(reach_m) +
                         " m far; leave extras.units out to have it fitted");
    } else if (!lies_within(workspace, box)) {
        scene.remarks.emplace_back(
            "the scene is in metres and lies partly outside the device's workspace");
    }
    scene.lower_m = box.lower;
    scene.upper_m = box.upper;
}

void build_meshes(Scene &scene, const std::vector<PlacedPrimitive> &primitives,
                  const tinygltf::Model &model) {
    TextureLibrary textures(model);
    const PlacedMesh *node = nullptr;
    std::vector<SurfaceMaterial> &materials = scene.surface.materials;
    for (const PlacedPrimitive &primitive : primitives) {
        if (primitive.node != node) { // the primitives of a node stand together
            node = primitive.node;
            if (materials.size() > std::numeric_limits<std::uint16_t>::max()) {
                throw InputError("has more than " + std::to_string(materials.size()) +
                                 " nodes with triangles; join some");
            }
            materials.push_back({node->name, node->eta});
        }
        add_surface(primitive, static_cast<std::uint16_t>(materials.size() - 1), scene.surface);
        scene.meshes.push_back(visual_mesh(primitive, textures, scene.remarks));
    }
    scene.textures = textures.take();
}

Scene load(const std::filesystem::path &file, const Workspace &workspace) {
    const tinygltf::Model model = read_model(file);
    Scene scene;
    scene.file = file;
    scene.in_metres = is_in_metres(model);
    scene.remarks = left_out_of(model);
    const std::vector<PlacedMesh> nodes = place_meshes(model);
    MeshCache cache(model);
    std::vector<PlacedPrimitive> primitives = gather(nodes, cache, scene.remarks);
    if (primitives.empty()) {
        throw InputError("has no triangle to touch" +
                         (scene.remarks.empty() ? "" : " (" + scene.remarks.front() + ")"));
    }
    fit_scene(scene, primitives, workspace);
    build_meshes(scene, primitives, model);
    return scene;
}

} // namespace

Scene load_gltf(const std::filesystem::path &file, const Workspace &workspace) {
    const std::string place = gltf::one_line(file.string(), 1000) + ": ";
    try {
        return load(file, workspace);
    } catch (const InputError &error) {
        throw InputError(place + gltf::one_line(error.what(), 500));
    } catch (const std::bad_alloc &) {
        throw InputError(place + "needs more memory than there is; simplify it");
    } catch (const std::exception &error) {
        throw InputError(place + "cannot be read: " + gltf::one_line(error.what()));
    }
}

} // namespace springdrive

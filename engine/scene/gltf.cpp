#include "engine/scene/gltf.h"

#include "base/cancellation.h"
#include "base/input_error.h"
#include "base/text.h"
#include "engine/scene/gltf_file.h"
#include "engine/scene/gltf_material.h"
#include "engine/scene/gltf_mesh.h"
#include "engine/scene/gltf_nodes.h"
#include "engine/scene/load_messages.h"
#include "engine/scene/scene.h"
#include "engine/scene/shape_fit.h"
#include "engine/scene/visual_mesh.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <new>
#include <optional>
#include <span>

namespace springdrive::scene {

namespace {

using namespace gltf;

/// A primitive as its mesh has it, before a node places it.
struct PrimitiveData {
    const tinygltf::Primitive *source = nullptr;
    std::shared_ptr<const PrimitiveGeometry> geometry;
    DrawnMaterial material;
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
                const DrawnMaterial material = read_material(model_, primitive.material);
                entry->push_back({&primitive,
                                  std::make_shared<const PrimitiveGeometry>(
                                      read_primitive(model_, primitive, material)),
                                  material});
            }
        }
        return *entry;
    }

private:
    const tinygltf::Model &model_;
    std::vector<std::optional<std::vector<PrimitiveData>>> meshes_;
};

void warn_about(const PlacedMesh &node, const PrimitiveGeometry &geometry, WarningList &warnings) {
    if (geometry.untouchable_count) {
        warnings.add_of(node.label, &node, *geometry.untouchable_count,
                        geometry.untouchable + " cannot be touched or drawn");
    } else if (!geometry.untouchable.empty()) {
        warnings.add_of(node.label, &node, geometry.untouchable + " cannot be touched or drawn");
    }
    if (geometry.leftover_vertices > 0) {
        warnings.add_of(node.label, &node, geometry.leftover_vertices,
                        "vertices are left over and make no triangle");
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

/// Runs `step` for each node; messages of its errors begin with the node's label.
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

/// The maximum memory for loading at its peak, without textures.
constexpr double kMaxMemory_bytes = 8.0 * 1024 * 1024 * 1024;

/// Memory for a triangle and for a vertex at the peak: all copies that exist at the same time, in
/// file, scene and search structure. Measured with 9 to 19 million triangles, with shared and with
/// separate vertices, plus the additional memory of colours and texture coordinates.
constexpr double kPerTriangle_bytes = 300.0;
constexpr double kPerVertex_bytes = 220.0;

std::string in_GiB(double bytes) {
    return shortest_text(std::round(bytes / (1024.0 * 1024.0 * 1024.0) * 10.0) / 10.0) + " GiB";
}

/// Counts the triangles and vertices of a scene before memory for them is allocated.
class WorkBudget {
public:
    /// @throw InputError with both amounts if the sum exceeds the maximum.
    void add(std::size_t triangles, std::size_t vertices) {
        triangles_ += triangles;
        vertices_ += vertices;
        const double needed_bytes = kPerTriangle_bytes * static_cast<double>(triangles_) +
                                    kPerVertex_bytes * static_cast<double>(vertices_);
        if (needed_bytes > kMaxMemory_bytes) {
            throw InputError("with it the scene has " + std::to_string(triangles_) +
                             " triangles and " + std::to_string(vertices_) +
                             " vertices, for which loading needs about " + in_GiB(needed_bytes) +
                             " of memory; at most " + in_GiB(kMaxMemory_bytes) +
                             " are allowed: simplify it");
        }
    }

private:
    std::size_t triangles_ = 0;
    std::size_t vertices_ = 0;
};

/// Adds what the file declares of a primitive, so that a scene is refused before it is read. Each
/// set of joints and each morph target that changes its vertices counts as so many vertices more.
void add_declared(const tinygltf::Model &model, const PlacedMesh &node,
                  const tinygltf::Primitive &primitive, WorkBudget &allowance) {
    const auto position = primitive.attributes.find("POSITION");
    const bool is_drawn_by_line =
        primitive.mode >= TINYGLTF_MODE_POINTS && primitive.mode < TINYGLTF_MODE_TRIANGLES;
    if (position == primitive.attributes.end() || is_drawn_by_line) {
        return;
    }
    const std::size_t vertices = accessor_count(model, position->second);
    const std::size_t corners =
        primitive.indices >= 0 ? accessor_count(model, primitive.indices) : vertices;
    constexpr std::size_t kTooMany =
        std::numeric_limits<std::size_t>::max() / 4; // no sum overflows
    allowance.add(
        std::min(primitive.mode == TINYGLTF_MODE_TRIANGLES ? corners / 3 : corners, kTooMany),
        std::min(vertices, kTooMany));
    for (const double weight : node.morph_weights) {
        allowance.add(0, weight == 0.0 ? 1 : std::min(vertices, kTooMany));
    }
    for (const auto &attribute : primitive.attributes) {
        if (!model.skins.empty() && attribute.first.starts_with("JOINTS_")) {
            allowance.add(0, std::min(vertices, kTooMany));
        }
    }
}

void check_declared(const tinygltf::Model &model, const std::vector<PlacedMesh> &nodes) {
    WorkBudget allowance;
    if (std::ranges::any_of(nodes, [](const PlacedMesh &node) { return node.touch.smooth; })) {
        allowance.add(kMaxCurvedTriangles, kMaxCurvedTriangles);
    }
    for_each_node(nodes, [&](const PlacedMesh &node) {
        for (const auto &primitive : model.meshes[static_cast<std::size_t>(node.mesh)].primitives) {
            add_declared(model, node, primitive, allowance);
        }
    });
}

/// The primitives of all nodes, those of one node adjacent, in the file's own world coordinates.
/// `warnings` gains what cannot be touched or drawn.
/// @param nodes are pointed at by the result
/// @throw InputError naming the node, for what cannot be read, is not finite or is too much.
std::vector<PlacedPrimitive> gather(const tinygltf::Model &model,
                                    const std::vector<PlacedMesh> &nodes, WarningList &warnings,
                                    LoadProgress &progress) {
    check_declared(model, nodes);
    std::vector<PlacedPrimitive> gathered;
    MeshCache cache(model);
    WorkBudget allowance; // of what was read: compressed data may hold more than declared
    std::size_t done = 0;
    for_each_node(nodes, [&](const PlacedMesh &node) {
        for (const PrimitiveData &primitive : cache.primitives(node.mesh)) {
            stop_if_given_up();
            const PrimitiveGeometry &geometry = *primitive.geometry;
            warn_about(node, geometry, warnings);
            if (!geometry.triangles.empty()) {
                allowance.add(geometry.triangles.size(),
                              geometry.position.count() * (1 + geometry.joint_sets.size()));
                const std::shared_ptr<const PrimitiveGeometry> rest =
                    at_rest(model, *primitive.source, primitive.geometry, node, warnings);
                gathered.push_back({&node,
                                    rest,
                                    primitive.material,
                                    used_box(*rest),
                                    world_positions(node, *rest),
                                    {}});
            }
        }
        progress.advance_to(static_cast<double>(++done) / static_cast<double>(nodes.size()));
    });
    return gathered;
}

/// The warning that explains best why there is nothing to touch.
std::string first_untouchable(const std::vector<std::string> &warnings) {
    const auto found = std::ranges::find_if(warnings, [](const std::string &warning) {
        return warning.find("cannot be touched") != std::string::npos;
    });
    return found != warnings.end() ? *found : warnings.empty() ? std::string() : warnings.front();
}

constexpr double kFarthest_m = 1000.0; // beyond this, "metres" must be a mistake

BoundingBox bounds_of(const std::vector<PlacedPrimitive> &primitives) {
    BoundingBox box;
    for (const PlacedPrimitive &primitive : primitives) {
        stop_if_given_up();
        for (const Triangle &triangle : primitive.geometry->triangles) {
            for (const std::uint32_t corner : triangle) {
                box.include(primitive.positions[corner]);
            }
        }
    }
    return box;
}

/// Moves the primitives into the device's frame.
/// @return from the file's world coordinates to that frame
Fit fit_scene(Scene &scene, std::vector<PlacedPrimitive> &primitives,
              const device::Workspace &workspace, WarningList &warnings) {
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
        throw InputError("it says that it is in metres, but reaches " + shortest_text(reach_m) +
                         " m far; leave extras.units out to have it fitted");
    } else if (!lies_within(workspace, box)) {
        warnings.add("the scene is in metres and lies partly outside the device's workspace");
    }
    scene.lower_m = box.lower;
    scene.upper_m = box.upper;
    return scene.in_metres ? Fit{} : fit;
}

/// The shape that the node of `primitives` is touched as.
contact::AnalyticShape shape_of(std::span<const PlacedPrimitive> primitives, const Fit &fit,
                                std::uint16_t material) {
    BoundingBox box;
    for (const PlacedPrimitive &primitive : primitives) {
        box.include(primitive.box.lower);
        box.include(primitive.box.upper);
    }
    const PlacedMesh &node = *primitives.front().node;
    const Eigen::Affine3d to_device = Eigen::Translation3d(fit.to_m) * Eigen::Scaling(fit.scale) *
                                      Eigen::Translation3d(-fit.from) * node.to_world;
    return fit_shape(*node.touch.shape, box, to_device, material, node.label);
}

/// What is touched of one node: its triangles or its shape.
void add_touch(Scene &scene, std::span<const PlacedPrimitive> primitives, const Fit &fit) {
    const TouchExtras &touch = primitives.front().node->touch;
    std::vector<contact::SurfaceMaterial> &materials = scene.surface.materials;
    if (materials.size() > std::numeric_limits<std::uint16_t>::max()) {
        throw InputError("has more than " + std::to_string(materials.size()) +
                         " nodes with triangles; join some");
    }
    const auto material = static_cast<std::uint16_t>(materials.size());
    materials.push_back(touch.material);
    if (touch.shape) {
        if (scene.shapes.size() == contact::kMaxShapes) {
            throw InputError("has more than " + std::to_string(contact::kMaxShapes) +
                             " nodes that are touched as shapes; let some be touched as meshes");
        }
        scene.shapes.push_back(shape_of(primitives, fit, material));
        return;
    }
    for (const PlacedPrimitive &primitive : primitives) {
        add_surface(primitive, material, scene.surface);
    }
}

/// Words on the middle of the upper side of what a node has.
void add_caption(Scene &scene, std::span<const PlacedPrimitive> primitives) {
    const std::string &text = primitives.front().node->touch.caption;
    if (text.empty()) {
        return;
    }
    BoundingBox box;
    for (const PlacedPrimitive &primitive : primitives) {
        for (const Vector3 &position : primitive.positions) {
            box.include(position);
        }
    }
    Vector3 at_m = 0.5 * (box.lower + box.upper);
    at_m.y() = box.upper.y();
    scene.captions.push_back({text, at_m});
}

bool has_smooth(const std::vector<PlacedPrimitive> &primitives) {
    return std::ranges::any_of(
        primitives, [](const PlacedPrimitive &primitive) { return primitive.node->touch.smooth; });
}

/// The triangles of unbent primitives, with the materials of those that are touched.
contact::TriangleSoup flat_touch(std::vector<PlacedPrimitive> primitives, const Fit &fit,
                                 const contact::TriangleSoup &bent) {
    contact::TriangleSoup flat;
    flat.materials = bent.materials;
    std::uint16_t material = 0;
    for (std::span rest(primitives); !rest.empty(); ++material) {
        const std::span node = rest.first(first_node_size(rest));
        rest = rest.subspan(node.size());
        for (PlacedPrimitive &primitive : node) {
            if (primitive.node->touch.shape) {
                continue;
            }
            for (Vector3 &position : primitive.positions) {
                position = fit(position);
            }
            add_surface(primitive, material, flat);
        }
    }
    return flat;
}

/// Frees the primitives one by one, so that the whole scene is never in memory twice.
void build_meshes(Scene &scene, std::vector<PlacedPrimitive> primitives, const Fit &fit,
                  const tinygltf::Model &model, WarningList &warnings, LoadProgress &progress) {
    for (std::span rest(primitives); !rest.empty();) {
        const std::size_t size = first_node_size(rest);
        add_touch(scene, rest.first(size), fit);
        add_caption(scene, rest.first(size));
        rest = rest.subspan(size);
    }
    TextureLibrary textures(model, folder_of(scene.file));
    for (std::size_t i = 0; i < primitives.size(); ++i) {
        std::ranges::move(visual_meshes(primitives[i], textures, warnings),
                          std::back_inserter(scene.meshes));
        primitives[i] = {};
        progress.advance_to(static_cast<double>(i + 1) / static_cast<double>(primitives.size()));
    }
    scene.textures = textures.take();
    scene.creases = creases_of(scene.meshes);
}

Scene load(const std::filesystem::path &file, const device::Workspace &workspace,
           const std::string &gltf_scene, LoadProgress &progress) {
    using Stage = LoadProgress::Stage;
    progress.begin(Stage::reading, false);
    Scene scene;
    scene.file = file;
    WarningList warnings;
    tinygltf::Model model = read_model(file, warnings);
    model.defaultScene = choose_scene(model, gltf_scene, warnings);
    const SceneExtras extras = read_scene_extras(model, warnings);
    scene.in_metres = extras.in_metres;
    scene.planar = extras.planar;
    scene.tolerance = extras.tolerance;
    scene.lesson = extras.lesson;
    const std::vector<PlacedMesh> nodes = place_meshes(model, warnings);
    progress.begin(Stage::gathering, true);
    std::vector<PlacedPrimitive> primitives = gather(model, nodes, warnings, progress);
    if (primitives.empty()) {
        const std::string why = first_untouchable(warnings.lines());
        throw InputError("has no triangle to touch" + (why.empty() ? "" : " (" + why + ")"));
    }
    progress.begin(Stage::bending, false);
    std::vector<PlacedPrimitive> flat;
    if (has_smooth(primitives)) {
        flat = primitives;
    }
    bend_smooth_nodes(primitives, warnings);
    progress.begin(Stage::placing, true);
    const Fit fit = fit_scene(scene, primitives, workspace, warnings);
    if (scene.lesson.spot) {
        scene.lesson.spot->point_m = fit(scene.lesson.spot->point_m);
    }
    build_meshes(scene, std::move(primitives), fit, model, warnings, progress);
    if (!flat.empty()) {
        scene.flat_surface = flat_touch(std::move(flat), fit, scene.surface);
    }
    scene.warnings = warnings.lines();
    return scene;
}

} // namespace

Scene load_gltf(const std::filesystem::path &file, const device::Workspace &workspace,
                LoadProgress *progress, const std::string &gltf_scene) {
    LoadProgress unwatched;
    LoadProgress &watched = progress != nullptr ? *progress : unwatched;
    const StopScope given_up(&watched.is_cancelled());
    const std::string place = one_line(file.string(), 1000) + ": ";
    try {
        return load(file, workspace, gltf_scene, watched);
    } catch (const Cancelled &) {
        throw; // not an error of the file
    } catch (const InputError &error) {
        throw InputError(place + one_line(error.what(), 500));
    } catch (const std::bad_alloc &) {
        throw InputError(place + "needs more memory than there is; simplify it");
    } catch (const std::exception &error) {
        throw InputError(place + "cannot be read: " + one_line(error.what()));
    }
}

} // namespace springdrive::scene

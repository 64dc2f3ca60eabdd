#include "engine/scene/gltf.h"

#include "base/input_error.h"
#include "base/wanted.h"
#include "engine/scene/fit.h"
#include "engine/scene/gltf_file.h"
#include "engine/scene/gltf_gather.h"
#include "engine/scene/gltf_material.h"
#include "engine/scene/gltf_mesh.h"
#include "engine/scene/gltf_nodes.h"
#include "engine/scene/gltf_text.h"
#include "engine/scene/scene_extras.h"
#include "engine/scene/shape_fit.h"
#include "engine/scene/smooth_nodes.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <new>
#include <span>

namespace springdrive::scene {

namespace {

using namespace gltf;

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

/// Puts everything where it belongs in the device's frame.
/// @return from the file's world coordinates to there
Fit fit_scene(Scene &scene, std::vector<PlacedPrimitive> &primitives,
              const device::Workspace &workspace) {
    BoundingBox box = bounds_of(primitives);
    Fit fit = fit_into(workspace, box); // also refuses what has no extent
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
        if (scene.shapes.size() == contact::kMostShapes) {
            throw InputError("has more than " + std::to_string(contact::kMostShapes) +
                             " nodes that are touched as shapes; let some be touched as meshes");
        }
        scene.shapes.push_back(shape_of(primitives, fit, material));
        return;
    }
    for (const PlacedPrimitive &primitive : primitives) {
        add_surface(primitive, material, scene.surface);
    }
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

/// Lets go of the primitives one by one, so that not all is there twice.
void build_meshes(Scene &scene, std::vector<PlacedPrimitive> primitives, const Fit &fit,
                  const tinygltf::Model &model, LoadProgress &progress) {
    for (std::span rest(primitives); !rest.empty();) {
        const std::size_t size = first_node_size(rest);
        add_touch(scene, rest.first(size), fit);
        rest = rest.subspan(size);
    }
    TextureLibrary textures(model);
    for (std::size_t i = 0; i < primitives.size(); ++i) {
        std::ranges::move(visual_meshes(primitives[i], textures, scene.remarks),
                          std::back_inserter(scene.meshes));
        primitives[i] = {};
        progress.advance_to(static_cast<double>(i + 1) / static_cast<double>(primitives.size()));
    }
    scene.textures = textures.take();
}

Scene load(const std::filesystem::path &file, const device::Workspace &workspace,
           LoadProgress &progress) {
    using Stage = LoadProgress::Stage;
    progress.begin(Stage::reading, false);
    const tinygltf::Model model = read_model(file);
    Scene scene;
    scene.file = file;
    const SceneExtras said = read_scene_extras(model);
    scene.in_metres = said.in_metres;
    scene.planar = said.planar;
    scene.tolerance = said.tolerance;
    scene.remarks = left_out_of(model);
    const std::vector<PlacedMesh> nodes = place_meshes(model);
    progress.begin(Stage::gathering, true);
    std::vector<PlacedPrimitive> primitives = gather(model, nodes, scene.remarks, progress);
    if (primitives.empty()) {
        throw InputError("has no triangle to touch" +
                         (scene.remarks.empty() ? "" : " (" + scene.remarks.front() + ")"));
    }
    progress.begin(Stage::bending, false);
    std::vector<PlacedPrimitive> flat;
    if (has_smooth(primitives)) {
        flat = primitives;
    }
    bend_smooth_nodes(primitives, scene.remarks);
    progress.begin(Stage::placing, true);
    const Fit fit = fit_scene(scene, primitives, workspace);
    build_meshes(scene, std::move(primitives), fit, model, progress);
    if (!flat.empty()) {
        scene.flat_surface = flat_touch(std::move(flat), fit, scene.surface);
    }
    return scene;
}

} // namespace

Scene load_gltf(const std::filesystem::path &file, const device::Workspace &workspace,
                LoadProgress *progress) {
    LoadProgress unwatched;
    LoadProgress &watched = progress != nullptr ? *progress : unwatched;
    const GivenUpBy given_up(&watched.is_given_up());
    const std::string place = gltf::one_line(file.string(), 1000) + ": ";
    try {
        return load(file, workspace, watched);
    } catch (const NotWanted &) {
        throw; // no fault of the file's
    } catch (const InputError &error) {
        throw InputError(place + gltf::one_line(error.what(), 500));
    } catch (const std::bad_alloc &) {
        throw InputError(place + "needs more memory than there is; simplify it");
    } catch (const std::exception &error) {
        throw InputError(place + "cannot be read: " + gltf::one_line(error.what()));
    }
}

} // namespace springdrive::scene

#include "engine/scenario/touch_scene.h"

#include "engine/scenario/test_surfaces.h"
#include "engine/scene/fit.h"
#include "engine/scene/gltf.h"

#include <optional>
#include <utility>

namespace springdrive {

Scene touch_scene(const std::string &name, const Workspace &workspace, LoadProgress *progress) {
    std::optional<TriangleSoup> surface = test_surface_named(name);
    if (!surface) {
        return load_gltf(name, workspace, progress);
    }
    BoundingBox box;
    for (const Vector3 &vertex_m : surface->vertices_m) {
        box.include(vertex_m);
    }
    Scene scene;
    scene.file = name;
    scene.surface = std::move(*surface);
    scene.lower_m = box.lower;
    scene.upper_m = box.upper;
    scene.in_metres = true;
    return scene;
}

HapticSurface haptic_surface_of(const Scene &scene) {
    return HapticSurface(scene.surface, scene.shapes);
}

} // namespace springdrive

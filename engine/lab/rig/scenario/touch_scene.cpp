#include "engine/lab/rig/scenario/touch_scene.h"

#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/scene/fit.h"
#include "engine/scene/gltf.h"

#include <optional>
#include <utility>

namespace springdrive::rig {

scene::Scene touch_scene(const std::string &name, const device::Workspace &workspace,
                         scene::LoadProgress *progress) {
    std::optional<contact::TriangleSoup> surface = test_surface_named(name);
    if (!surface) {
        return scene::load_gltf(name, workspace, progress);
    }
    scene::BoundingBox box;
    for (const Vector3 &vertex_m : surface->vertices_m) {
        box.include(vertex_m);
    }
    scene::Scene scene;
    scene.file = name;
    scene.surface = std::move(*surface);
    scene.lower_m = box.lower;
    scene.upper_m = box.upper;
    scene.in_metres = true;
    return scene;
}

} // namespace springdrive::rig

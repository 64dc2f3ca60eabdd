#include "engine/lab/rig/scenario/touch_scene.h"

#include "base/input_error.h"
#include "base/one_line.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/scene/fit.h"
#include "engine/scene/gltf.h"

#include <new>
#include <optional>
#include <string>
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

contact::HapticSurface haptic_surface_of(const scene::Scene &scene) {
    const std::string place = one_line(scene.file.string(), 1000) + ": ";
    const auto prepared = [&] {
        try {
            return contact::HapticSurface(scene.surface, scene.shapes);
        } catch (const InputError &error) {
            throw InputError(place + error.what());
        } catch (const std::bad_alloc &) {
            throw InputError(place + "needs more memory than there is; simplify it");
        }
    };
    contact::HapticSurface surface = prepared();
    if (surface.report().triangles_kept == 0 && surface.shapes().empty()) {
        throw InputError(place + "has nothing to touch: its triangles, " +
                         std::to_string(surface.report().triangles_given) +
                         " in number, are all too thin to have a normal; export it again");
    }
    return surface;
}

} // namespace springdrive::rig

// Surfaces and settings that tests of model choice share.
#pragma once

#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/model_selection/model_run.h"
#include "engine/lab/rig/scenario/scenarios.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/scene/gltf.h"
#include "tests/support/devices.h"

#include <string>

namespace springdrive::testing {

inline scene::Scene own_scene(const std::string &name) {
    return scene::load_gltf(assets() / "scenes" / (name + ".gltf"), phantom_1_0().workspace);
}

/// A sphere of 45 mm within reach; for `divisions` see `icosphere`.
inline contact::TriangleSoup ball(int divisions) {
    contact::TriangleSoup soup = rig::icosphere(divisions, 0.045);
    for (Vector3 &vertex_m : soup.vertices_m) {
        vertex_m += Vector3(0.0, 0.05, -0.015);
    }
    return soup;
}

/// A hand that explores a surface within `box`.
inline model_selection::ModelSetting exploring(const contact::HapticSurface &surface,
                                               const Eigen::AlignedBox3d &box,
                                               const rig::Exploration &how = {}) {
    const device::DeviceDescription device = phantom_1_0();
    return {
        rig::exploration_scenario({device, {}}, rig::placed(surface, box.min(), box.max()), how),
        control::global_alpha_bound(device)};
}

inline Eigen::AlignedBox3d box_of(const scene::Scene &scene) {
    return {scene.lower_m, scene.upper_m};
}

inline Eigen::AlignedBox3d box_of(const contact::TriangleSoup &soup) {
    Eigen::AlignedBox3d box;
    for (const Vector3 &vertex_m : soup.vertices_m) {
        box.extend(vertex_m);
    }
    return box;
}

} // namespace springdrive::testing

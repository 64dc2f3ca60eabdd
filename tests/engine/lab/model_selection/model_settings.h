// Surfaces and settings that tests of model choice share.
#pragma once

#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/model_selection/feeling_hand.h"
#include "engine/lab/model_selection/model_run.h"
#include "engine/lab/rig/scenario/scripted_touch.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/scene/gltf.h"
#include "tests/support/devices.h"

#include <string>

namespace springdrive::testing {

inline scene::Scene own_scene(const std::string &name) {
    return scene::load_gltf(assets() / "scenes" / (name + ".gltf"), phantom_1_0().workspace);
}

/// A sphere of 45 mm within reach, of so many divisions; see `icosphere`.
inline contact::TriangleSoup ball(int divisions) {
    contact::TriangleSoup soup = rig::icosphere(divisions, 0.045);
    for (Vector3 &vertex_m : soup.vertices_m) {
        vertex_m += Vector3(0.0, 0.05, -0.015);
    }
    return soup;
}

/// A hand that feels all over a surface within `box`.
inline model_selection::ModelSetting feeling(const contact::HapticSurface &surface,
                                             const Eigen::AlignedBox3d &box,
                                             const model_selection::FeelingHand &how = {}) {
    const device::DeviceDescription device = phantom_1_0();
    const Vector3 start_m = rig::start_above(device, box.min(), box.max());
    return {device,
            {},
            1e-3,
            0,
            model_selection::feeling_hand(device, surface, box, start_m, how),
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

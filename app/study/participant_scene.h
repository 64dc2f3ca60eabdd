// The scene as a participant sees it: lit and with its shadows, the marked spot as a ring, and a
// ball. No device, no arrow, no caption, and no colour that could tell anything.
#pragma once

#include "app/view/camera.h"
#include "app/view/lit_programs.h"
#include "app/view/multisampled_target.h"
#include "app/view/scene_meshes.h"
#include "app/view/shadow_map.h"
#include "app/view/solid_painter.h"
#include "engine/scene/scene.h"

#include <optional>

namespace springdrive::app::study_screen {

/// Where a study's stimuli are felt.
struct MarkedSpot {
    Vector3 point_m{Vector3::Zero()};
    Vector3 normal{Vector3::UnitY()}; ///< unit, out of the surface
    double radius_m = 0.006;          ///< of the ring

    friend bool operator==(const MarkedSpot &, const MarkedSpot &) = default;
};

} // namespace springdrive::app::study_screen

// The cheapest model of a scene that its tolerance allows, found by measuring on this machine.
#pragma once

#include "engine/session/model/model_chooser.h"

namespace springdrive::model_selection {

/// Lets a hand explore the scene (`exploration_path`) with the fullest model and with each
/// candidate in turn, and chooses by the rule of `choose_model`. Takes seconds.
///
/// The fullest: the last of `kPlantModels` in sub-steps of 32 µs or less, the surface as the scene
/// specifies it, and the last of `kMotionControllers`.
[[nodiscard]] ModelSelection choose_scene_model(const ModelQuestion &question,
                                                const ModelProgress &progress = {});

} // namespace springdrive::model_selection

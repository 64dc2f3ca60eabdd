// The cheapest model of a scene that its tolerance allows, found by measuring on this machine.
#pragma once

#include "device/core/device_description.h"
#include "engine/lab/model_selection/model_selection.h"
#include "engine/scene/scene.h"

#include <functional>
#include <memory>
#include <string>

namespace springdrive::model_selection {

/// The input of a choice.
struct ModelQuestion {
    const scene::Scene *scene = nullptr;
    device::DeviceDescription device;
    control::Tuning tuning;
    double period_s = 1e-3;
    double delay_periods = 0.0;
};

/// Receives what is being measured and the overall progress, from 0 to 1.
using ModelProgress = std::function<void(const std::string &what, double share)>;

/// Lets a hand explore the scene (`exploration_path`) with the fullest model and with each
/// candidate in turn, and chooses by the rule of `choose_model`. Takes seconds.
///
/// The fullest: the last of `kPlantModels` in sub-steps of 32 µs or less, the surface as the scene
/// specifies it, and the last of `kMotionControllers`.
[[nodiscard]] ModelSelection choose_scene_model(const ModelQuestion &question,
                                                const ModelProgress &progress = {});

} // namespace springdrive::model_selection

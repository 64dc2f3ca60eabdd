// The forces on the hand with one model of a scene, tick by tick, and the difference between two
// models.
#pragma once

#include "device/core/haptic_device.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/contact/contact.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/control/motion_control.h"
#include "engine/lab/rig/scenario/scenarios.h"
#include "engine/session/model/model_selection.h"

#include <memory>
#include <vector>

namespace springdrive::model_selection {

/// The settings shared by all models of a scene.
struct ModelSetting {
    rig::Scenario scenario; ///< but for its tuning's map, and for what a model says of the plant
    double global_alpha_rad2_per_m2 = 0.0;
};

/// One element per tick in each.
struct ModelRun {
    std::vector<Vector3> force_N; ///< of the device on the hand, mean over the period
    std::vector<control::Configuration> configurations;
    std::vector<contact::Contact> contacts;
    std::vector<device::DeviceCommand> commands; ///< passed to the device in the tick

    [[nodiscard]] bool touches() const;
};

/// The simulated device of a model, at the start of the path.
[[nodiscard]] std::unique_ptr<simulated::SimulatedPhantom>
simulated_device(const ModelSetting &setting, const Model &model);

/// Runs the hand's whole path with servo law and simulated device in lockstep, without the safety
/// monitor, which could mask a model's behaviour.
/// @param surface  of the model's shape
[[nodiscard]] ModelRun run_model(const ModelSetting &setting, const Model &model,
                                 const contact::HapticSurface &surface);

/// Between two runs along the same path, both passed through a first-order low-pass. Infinite for a
/// run that diverged.
[[nodiscard]] ModelError model_error(const ModelRun &run, const ModelRun &fullest, double period_s,
                                     double bandwidth_hz);

} // namespace springdrive::model_selection

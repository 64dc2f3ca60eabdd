// What a hand feels of a scene with one model of it, tick by tick, and how far two models differ.
#pragma once

#include "device/core/haptic_device.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/contact/contact.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/control/motion_control.h"
#include "engine/lab/model_selection/model.h"
#include "engine/lab/rig/scenario/scenarios.h"
#include "engine/scene/model_tolerance.h"

#include <memory>
#include <vector>

namespace springdrive::model_selection {

/// What all models of a scene have in common.
struct ModelSetting {
    rig::Scenario scenario; ///< but for its tuning's map, and for what a model says of the plant
    double global_alpha_rad2_per_m2 = 0.0;
};

/// One element a tick in each.
struct ModelRun {
    std::vector<Vector3> force_N; ///< of the device on the hand, mean over the period
    std::vector<control::Configuration> configurations;
    std::vector<contact::Contact> contacts;
    std::vector<device::DeviceCommand> commands; ///< that the device got in the tick

    [[nodiscard]] bool touches() const;
};

/// The simulated device that a model asks for, at the start of the path.
[[nodiscard]] std::unique_ptr<simulated::SimulatedPhantom>
simulated_device(const ModelSetting &setting, const Model &model);

/// The hand's path from its start to its end, servo law and simulated device in lockstep, without
/// the safety monitor: nothing may hide what a model does.
/// @param surface  of the model's shape
[[nodiscard]] ModelRun run_model(const ModelSetting &setting, const Model &model,
                                 const contact::HapticSurface &surface);

/// How far what is felt is from what should be.
struct ModelError {
    double force_N = 0.0;       ///< rms of the difference over the whole path
    double direction_rad = 0.0; ///< rms of the angle, while both touch with 0.2 N or more
};

/// Between two runs along the same path, both passed through a low-pass of first order. A run that
/// went out of the finite is infinitely far off.
[[nodiscard]] ModelError model_error(const ModelRun &run, const ModelRun &fullest, double period_s,
                                     double bandwidth_hz);

} // namespace springdrive::model_selection

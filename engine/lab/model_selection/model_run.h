// The forces on the hand with one model of a scene, tick by tick, the difference between two
// models, and the cost of the parts of a model per servo tick, measured on this machine.
#pragma once

#include "base/timing.h"
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

// Candidates take turns, so that other load of the machine affects all of them alike.

/// The device's exchange with each model [ns a tick], with the commands of a run.
[[nodiscard]] std::vector<Cost> plant_costs(const ModelSetting &setting,
                                            const std::vector<Model> &models, const ModelRun &run);

/// The proxy's update on each surface [ns a tick], with the tips of a run.
[[nodiscard]] std::vector<Cost>
contact_costs(const std::vector<const contact::HapticSurface *> &surfaces, const ModelRun &run);

/// From set-point of the tip to voltages [ns a tick], with configurations and contacts of a run: of
/// each map alone. The servo also evaluates the other map, for the panel that compares them.
[[nodiscard]] std::vector<Cost> control_costs(const ModelSetting &setting,
                                              const std::vector<MotionController> &controllers,
                                              const ModelRun &run);

} // namespace springdrive::model_selection

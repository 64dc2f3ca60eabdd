// The cost of the parts of a model per servo tick, measured on this machine.
#pragma once

#include "base/timing.h"
#include "engine/lab/model_selection/model_run.h"

#include <vector>

namespace springdrive::model_selection {

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

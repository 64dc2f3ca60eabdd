// Which model of a scene a session runs, as plain values.
#pragma once

#include "engine/lab/model_selection/model.h"

#include <optional>

namespace springdrive::session {

/// By default the model is what the other options make it, the scene's surface as it is given.
struct ModelOptions {
    /// The cheapest that the scene's tolerance allows; measured first if that is not known yet.
    bool automatic = false;
    /// Whether an automatic model may bring its motion controller: not where somebody tuned one.
    bool takes_controller = true;
    // What is set counts in any case.
    std::optional<simulated::PlantModel> plant;
    std::optional<double> longest_step_s;
    std::optional<model_selection::ContactShape> surface;
};

} // namespace springdrive::session

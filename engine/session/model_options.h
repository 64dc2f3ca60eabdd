// Which model of a scene a session runs, as plain values.
#pragma once

#include "engine/model_choice/model.h"

#include <optional>

namespace springdrive {

/// By default the model is what the other options make it, the scene's surface as it is given.
struct ModelOptions {
    /// The cheapest that the scene's tolerance allows; measured first if that is not known yet.
    bool automatic = false;
    /// Whether an automatic model may bring its motion controller: not where somebody tuned one.
    bool takes_controller = true;
    // What is set counts in any case.
    std::optional<PlantModel> plant;
    std::optional<double> longest_step_s;
    std::optional<ContactShape> surface;
};

} // namespace springdrive

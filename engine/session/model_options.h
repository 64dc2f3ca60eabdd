// Options for the model of a scene that a session runs.
#pragma once

#include "engine/session/model/model_chooser.h"

#include <memory>
#include <optional>

namespace springdrive::session {

/// By default the other options determine the model, and the scene's surface is used as it is.
struct ModelOptions {
    /// Must be there for `automatic`, for `surface`, and for a session that measures models.
    std::shared_ptr<const model_selection::ModelChooser> chooser;
    /// Use the cheapest model that meets the scene's tolerance; measured first if it is not cached.
    bool automatic = false;
    /// Whether an automatic model may set the motion controller: not if the user has tuned one.
    bool takes_controller = true;
    // Values that are set take precedence.
    std::optional<simulated::PlantModel> plant;
    std::optional<double> longest_step_s;
    std::optional<model_selection::ContactShape> surface;
};

} // namespace springdrive::session

// The model of a scene, with progress shown on a terminal.
#pragma once

#include "engine/session/model_measurement.h"

namespace springdrive::app {

/// The cached choice, or else a measured one, with a progress line on standard error if that is a
/// terminal.
/// @param fresh  measure even if a choice is cached
[[nodiscard]] model_selection::ModelSelection
selection_with_line(const model_selection::ModelQuestion &question,
                    const session::ModelMemory &memory, bool fresh);

} // namespace springdrive::app

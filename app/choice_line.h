// Which model a scene gets, for those who wait before a terminal.
#pragma once

#include "engine/session/model_measurement.h"

namespace springdrive::app {

/// Remembered, or else measured, with a line of progress on standard error if that is a terminal.
/// @param fresh  measured even if it is remembered
[[nodiscard]] model_selection::ModelChoice
choice_with_line(const model_selection::ModelQuestion &question, const session::ModelMemory &memory,
                 bool fresh);

} // namespace springdrive::app

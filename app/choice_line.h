// Which model a scene gets, for those who wait before a terminal.
#pragma once

#include "engine/session/model_measurement.h"

namespace springdrive {

/// Remembered, or else measured, with a line of progress on standard error if that is a terminal.
/// @param fresh  measured even if it is remembered
[[nodiscard]] ModelChoice choice_with_line(const ModelQuestion &question, const ModelMemory &memory,
                                           bool fresh);

} // namespace springdrive

// What a simulated participant answers to a level.
#pragma once

#include "engine/study/conduct/conduct.h"
#include "engine/study/observers/simulated_sitting.h"

#include <optional>

namespace springdrive::study {

struct SimulatedAnswer {
    Response response; ///< none if it came too late
    std::optional<double> response_time_s;
};

/// A function of its arguments alone.
/// @param level  as it was delivered; below 0 on a logarithmic scale it counts as none
[[nodiscard]] SimulatedAnswer simulated_answer(const Protocol &protocol,
                                               const SimulatedParticipant &participant,
                                               const PlannedTrial &planned, double level);

} // namespace springdrive::study

// What a simulated participant has to judge: the delivered level.
#pragma once

#include "engine/study/protocol/protocol.h"
#include "engine/study/stimuli/stimulus_measures.h"

#include <optional>

namespace springdrive::study {

/// A presentation: its condition, and what it was measured by.
struct FeltPresentation {
    Condition condition;
    StimulusMeasures intended;
    StimulusMeasures delivered;
};

/// The variable under test as it was delivered: angle, pulse, press and speed as measured; of η,
/// K_P and dR in contact what would give the measured stiffness; of anything else the intended
/// value, as of what was not measured.
///
///   η = 1 − (1 − η_i) k      K_P = K_P,i k      dR = dR_i/k      k delivered over intended
///   stiffness
[[nodiscard]] double delivered_value(const Protocol &protocol, const FeltPresentation &felt);

/// The same as a level of the method. Without a standard in the trial it is what the protocol says.
[[nodiscard]] double delivered_level(const Protocol &protocol, const FeltPresentation &comparison,
                                     const std::optional<FeltPresentation> &standard);

} // namespace springdrive::study

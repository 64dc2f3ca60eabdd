// What the law finds in a tick, as its sample holds it.
#pragma once

#include "engine/control/haptic_law.h"
#include "engine/servo/servo_sample.h"

namespace springdrive::servo {

/// Notes η, α, x_Sd and θ_Sd, and the direction errors that both maps would render at rest. Uses
/// the sample's contact. RT-safe.
void note_law(const control::HapticLaw &law, const control::Configuration &now,
              const control::LawOutcome &found, ServoSample &sample) noexcept;

/// Notes the direction error of the sample's tip force against its contact; NaN without a force
/// that has a direction. RT-safe.
void note_rendered_error(ServoSample &sample) noexcept;

} // namespace springdrive::servo

// What the findings of a self-test mean for a first touch.
#pragma once

#include "engine/commissioning/finding.h"

#include <string>

namespace springdrive::app::assistant {

/// Whether the device must not be driven with it, however softly: the force could have another
/// direction, another sign, or another size than the servo takes it to have.
[[nodiscard]] bool is_unsafe(commissioning::Problem problem);

/// Of one that is not: what is then not known.
[[nodiscard]] std::string unchecked_by(commissioning::Problem problem);

} // namespace springdrive::app::assistant

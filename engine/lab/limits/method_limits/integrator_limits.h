// The steps above which integrators of the plant are unstable.
#pragma once

#include "engine/lab/limits/method_limits/method_limit.h"
#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

/// For a winding with its rotor held, and for the contact mode: a rotor with its load against the
/// inductive stiffness K_L (4) of a winding with a constant set-point.
[[nodiscard]] std::vector<LimitTrial> integrator_trials(const loops::StabilityCase &which);

} // namespace springdrive::limits

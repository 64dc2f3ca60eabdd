// The steps at which integrators of the plant go unstable.
#pragma once

#include "engine/lab/limits/failure_lines/failure_line.h"
#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

/// Of a winding with its rotor held, and of the contact mode: a rotor with what it carries against
/// the inductive stiffness K_L (4) of a winding whose set-point stands still.
[[nodiscard]] std::vector<TriedLine> integrator_lines(const loops::StabilityCase &which);

} // namespace springdrive::limits

// The steps at which integrators of the plant go unstable.
#pragma once

#include "engine/analysis/failure_lines/failure_line.h"
#include "engine/analysis/stability/stability_case.h"

namespace springdrive {

/// Of a winding with its rotor held, and of the contact mode: a rotor with what it carries against
/// the inductive stiffness K_L (4) of a winding whose set-point stands still.
[[nodiscard]] std::vector<TriedLine> integrator_lines(const StabilityCase &which);

} // namespace springdrive

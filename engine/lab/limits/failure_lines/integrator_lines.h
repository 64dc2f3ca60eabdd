// The steps above which integrators of the plant are unstable.
#pragma once

#include "engine/lab/limits/failure_lines/failure_line.h"
#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

/// For a winding with its rotor held, and for the contact mode: a rotor with its load against the
/// inductive stiffness K_L (4) of a winding with a constant set-point.
[[nodiscard]] std::vector<TriedLine> integrator_lines(const loops::StabilityCase &which);

} // namespace springdrive::limits

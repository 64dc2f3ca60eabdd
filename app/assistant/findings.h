// What stops a device, and what its self-test and calibration found: in words, with what to do
// about it and what it means for a first touch.
#pragma once

#include "app/assistant/step.h"
#include "engine/commissioning/calibration_run.h"
#include "engine/commissioning/device_checks.h"
#include "engine/servo/safety_status.h"

#include <string>

namespace springdrive::app::assistant {

/// Of the gravest of them.
[[nodiscard]] std::string remedy_of(device::BoardFaults faults);

/// What has to be done before the stop is reset.
[[nodiscard]] std::string remedy_of(const servo::SafetyStatus &stop);

/// What is not known of a device that is driven all the same, however softly. Empty if it must not
/// be: the force could have another direction, another sign, or another size than the servo takes
/// it to have.
[[nodiscard]] std::string unchecked_by(commissioning::Problem problem);

/// Adds a line for each motor, and what the numbers do not say.
/// @param device  with the numbers of its file
void describe(const device::Calibration &calibration, const device::DeviceDescription &device,
              StepReport &report);

/// Adds what R̂ may be by it, of the motor that is worst.
void describe_dR(const commissioning::CalibrationReport &found, StepReport &report);

/// Of a calibration that came to nothing, the verdict and the trouble. What self-test and
/// calibration do not agree on must not be passed; what was only not found out may be.
void judge(const commissioning::CalibrationReport &found, StepReport &report);

} // namespace springdrive::app::assistant

// What a calibration found, and what it means for a first touch, in words.
#pragma once

#include "app/assistant/step.h"
#include "engine/commissioning/calibration_run.h"

#include <string>
#include <vector>

namespace springdrive::app::assistant {

/// A line for each motor, and what the numbers do not say.
/// @param device  with the numbers of its file
[[nodiscard]] std::vector<std::string> words_of(const device::Calibration &calibration,
                                                const device::DeviceDescription &device);

/// What R̂ may be by it, of the motor that is worst.
[[nodiscard]] std::string words_on_dR(const commissioning::CalibrationReport &report);

/// Of a calibration that came to nothing. What self-test and calibration do not agree on must not
/// be passed; what was only not found out may be.
[[nodiscard]] Verdict verdict_on(commissioning::CalibrationProblem problem);

[[nodiscard]] Trouble trouble_of(const commissioning::CalibrationReport &report);

} // namespace springdrive::app::assistant

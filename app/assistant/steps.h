// All steps of the assistant.
#pragma once

#include "app/assistant/step.h"

#include <memory>

namespace springdrive::app::assistant {

/// Which device, its connection, and what it loses.
[[nodiscard]] std::unique_ptr<Step> make_link_step();
/// What the board says of itself, and whether the device file fits.
[[nodiscard]] std::unique_ptr<Step> make_identity_step();
/// Each joint by hand, with the picture following.
[[nodiscard]] std::unique_ptr<Step> make_motion_step();
/// Zeroing in the zero pose.
[[nodiscard]] std::unique_ptr<Step> make_zero_step();
/// commissioning::SelfTest.
[[nodiscard]] std::unique_ptr<Step> make_self_test_step();
/// commissioning::CalibrationRun.
[[nodiscard]] std::unique_ptr<Step> make_calibration_step();
/// A soft touch within lowered limits.
[[nodiscard]] std::unique_ptr<Step> make_touch_step();

} // namespace springdrive::app::assistant

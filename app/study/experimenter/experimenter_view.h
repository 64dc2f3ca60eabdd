// What the experimenter's view shows of the device and the hand.
#pragma once

#include "app/view/view_state.h"
#include "device/core/device_description.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/servo/servo_sample.h"

#include <optional>

namespace springdrive::app::study_screen {

/// @param surface    that is touched
/// @param hidden_at  while stimuli are hidden: where the tip is shown in contact, whichever way it
///                   yields; no force is shown then, in contact or not
[[nodiscard]] ViewState experimenter_view(const servo::ServoSample &now,
                                          const device::DeviceDescription &device,
                                          const contact::HapticSurface &surface,
                                          const std::optional<Vector3> &hidden_at);

} // namespace springdrive::app::study_screen

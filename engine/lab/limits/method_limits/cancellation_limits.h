// Where resistance cancellation (6) fails: dR ≤ 0.
#pragma once

#include "device/core/device_description.h"
#include "engine/lab/limits/method_limits/method_limit.h"

namespace springdrive::limits {

/// For the second motor, its rotor held: a small current behind the amplifier grows where R̂
/// exceeds R(T, θ), because of cold, of the commutator or of a wrong setting; without and with the
/// winding guard.
[[nodiscard]] std::vector<LimitTrial> cancellation_trials(const device::DeviceDescription &device);

} // namespace springdrive::limits

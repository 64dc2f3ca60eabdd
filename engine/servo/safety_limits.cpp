#include "engine/servo/safety_limits.h"

#include <algorithm>

namespace springdrive::servo {

SafetyLimits limits_of(const device::DeviceDescription &device) {
    SafetyLimits limits;
    for (const device::MotorParameters &motor : device.motor) {
        limits.voltage_V = std::max(limits.voltage_V, motor.supply_V);
        limits.current_A = std::max(limits.current_A, motor.peak_current_A);
        limits.winding_C = std::max(limits.winding_C, motor.thermal.max_winding_C);
    }
    limits.tip_force_N = device.limits.tip_force_N;
    limits.tip_speed_m_per_s = device.limits.tip_speed_m_per_s;
    limits.beyond_stops_rad = device.limits.beyond_stops_rad;
    limits.generated_energy_J = device.limits.generated_energy_J;
    limits.late_s = device.limits.late_s;
    limits.stale_s = device.limits.stale_s;
    limits.window_silence_s = device.limits.window_silence_s;
    return limits;
}

SafetyLimits lowered(const SafetyLimits &device, const SafetyLimits &request) noexcept {
    SafetyLimits limits = device;
    for (const SafetyLimit &limit : kSafetyLimits) {
        const double wanted = request.*limit.value;
        if (wanted > 0.0) { // false for NaN too
            limits.*limit.value = std::min(device.*limit.value, wanted);
        }
    }
    return limits;
}

} // namespace springdrive::servo

// One device of a kind: its motors and current sensors, drawn at random within the tolerances of
// the device file.
#pragma once

#include "device/core/device_description.h"

#include <array>
#include <cstdint>

namespace springdrive::simulated {

/// A sensor's reading of a current i is gain · i + offset.
struct SensorError {
    double gain = 1.0;
    double offset_A = 0.0;
};

/// What measures one motor's current.
struct MotorSensing {
    SensorError converter; ///< for the servo
    SensorError amplifier; ///< for R̂ i of (6)
    double resolution_A = 0.0;
    double noise_A = 0.0; ///< r.m.s., of the converter
};

/// One motor's deviations from the device file.
struct DrawnMotor {
    double resistance_share = 1.0;
    double torque_constant_share = 1.0;
    double commutator_phase_rad = 0.0;
    MotorSensing sensing;
};

struct SampledDevice {
    std::array<DrawnMotor, 3> motor;
};

/// Each deviation is uniform within its tolerance, either way, and independent of the others; the
/// phase is uniform over a ripple. Seed 0 is the device of the file, with ideal sensors.
[[nodiscard]] SampledDevice sampled_device(const device::DeviceDescription &description,
                                           std::uint64_t seed);

} // namespace springdrive::simulated

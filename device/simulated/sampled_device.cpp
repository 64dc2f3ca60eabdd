#include "device/simulated/sampled_device.h"

#include "base/split_mix.h"

#include <numbers>
#include <random>

namespace springdrive::simulated {

namespace {

/// Uniform in [-1, 1], the same on every machine: the standard's distributions are not.
[[nodiscard]] double either_way(std::mt19937_64 &random) {
    return 2.0 * split_mix::unit_share(random()) - 1.0;
}

[[nodiscard]] SensorError draw_sensor(const device::CurrentSensing &sensing,
                                      std::mt19937_64 &random) {
    SensorError error;
    error.gain = 1.0 + sensing.gain_tolerance * either_way(random);
    error.offset_A = sensing.max_offset_A * either_way(random);
    return error;
}

} // namespace

SampledDevice sampled_device(const device::DeviceDescription &description, std::uint64_t seed) {
    SampledDevice drawn;
    if (seed == 0) {
        return drawn;
    }
    std::mt19937_64 random(seed);
    const device::CurrentSensing &sensing = description.current_sensing;
    for (std::size_t j = 0; j < drawn.motor.size(); ++j) {
        const device::MotorParameters &motor = description.motor[j];
        DrawnMotor &own = drawn.motor[j];
        own.resistance_share = 1.0 + motor.resistance_tolerance * either_way(random);
        own.torque_constant_share = 1.0 + motor.torque_constant_tolerance * either_way(random);
        own.commutator_phase_rad = std::numbers::pi * either_way(random);
        own.sensing.converter = draw_sensor(sensing, random);
        const SensorError separate = draw_sensor(sensing, random);
        own.sensing.amplifier = sensing.is_shared ? own.sensing.converter : separate;
        own.sensing.resolution_A = sensing.resolution_A;
        own.sensing.noise_A = sensing.noise_A;
    }
    return drawn;
}

} // namespace springdrive::simulated

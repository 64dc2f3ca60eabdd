// Covers device/simulated/plant_setup.cpp.
#include "device/simulated/plant_setup.h"

#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace springdrive::simulated {
namespace {

/// All deviations of a device, each relative to its tolerance.
std::vector<double> deviations(const device::DeviceDescription &device, std::uint64_t seed) {
    std::vector<double> found;
    const SampledDevice drawn = sampled_device(device, seed);
    for (std::size_t j = 0; j < 3; ++j) {
        const DrawnMotor &own = drawn.motor[j];
        const device::MotorParameters &motor = device.motor[j];
        found.push_back((own.resistance_share - 1.0) / motor.resistance_tolerance);
        found.push_back((own.torque_constant_share - 1.0) / motor.torque_constant_tolerance);
        found.push_back(own.commutator_phase_rad / std::numbers::pi);
        for (const SensorError &sensor : {own.sensing.converter, own.sensing.amplifier}) {
            found.push_back((sensor.gain - 1.0) / device.current_sensing.gain_tolerance);
            found.push_back(sensor.offset_A / device.current_sensing.max_offset_A);
        }
    }
    return found;
}

TEST(SampledDevice, IsThatOfTheFileForSeedZero) {
    const SampledDevice drawn = sampled_device(testing::phantom_1_0(), 0);
    for (const DrawnMotor &own : drawn.motor) {
        EXPECT_EQ(own.resistance_share, 1.0);
        EXPECT_EQ(own.torque_constant_share, 1.0);
        EXPECT_EQ(own.commutator_phase_rad, 0.0);
        EXPECT_EQ(own.sensing.converter.gain, 1.0);
        EXPECT_EQ(own.sensing.amplifier.offset_A, 0.0);
        EXPECT_EQ(own.sensing.noise_A, 0.0);
    }
}

/// Uniform within the tolerances, and independent: mean 0, variance 1/3, no correlation. Bounds of
/// five standard errors: one in a million if it is so, for each of some 250 comparisons.
TEST(SampledDevice, IsUniformWithinTheTolerances) {
    device::DeviceDescription device = testing::phantom_1_0();
    device.current_sensing.is_shared = false;
    constexpr int kSeeds = 4000;
    const std::size_t count = deviations(device, 1).size();
    std::vector<double> sum(count);
    std::vector<std::vector<double>> products(count, std::vector<double>(count));
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        const std::vector<double> drawn = deviations(device, seed);
        for (std::size_t i = 0; i < count; ++i) {
            ASSERT_LE(std::abs(drawn[i]), 1.0 + 1e-12);
            sum[i] += drawn[i];
            for (std::size_t k = 0; k <= i; ++k) {
                products[i][k] += drawn[i] * drawn[k];
            }
        }
    }
    const double root = std::sqrt(kSeeds);
    for (std::size_t i = 0; i < count; ++i) {
        EXPECT_LT(std::abs(sum[i] / kSeeds), 5.0 * std::sqrt(1.0 / 3.0) / root) << i;
        // The variance of u² is 4/45, of a product of two 1/9.
        EXPECT_NEAR(products[i][i] / kSeeds, 1.0 / 3.0, 5.0 * std::sqrt(4.0 / 45.0) / root) << i;
        for (std::size_t k = 0; k < i; ++k) {
            EXPECT_LT(std::abs(products[i][k] / kSeeds), 5.0 / 3.0 / root) << i << ' ' << k;
        }
    }
}

TEST(SampledDevice, MayHaveOneSensorForBoth) {
    device::DeviceDescription device = testing::phantom_1_0();
    for (const bool is_shared : {true, false}) {
        device.current_sensing.is_shared = is_shared;
        const MotorSensing sensing = sampled_device(device, 7).motor[1].sensing;
        EXPECT_EQ(sensing.converter.gain == sensing.amplifier.gain, is_shared);
        EXPECT_EQ(sensing.converter.offset_A == sensing.amplifier.offset_A, is_shared);
    }
}

} // namespace
} // namespace springdrive::simulated

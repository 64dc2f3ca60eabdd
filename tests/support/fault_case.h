// Random conditions of a fault: when, where and with which hand, from a seed.
#pragma once

#include "device/simulated/simulation_options.h"
#include "engine/control/tuning.h"

#include <cstdint>
#include <random>
#include <string>

namespace springdrive::testing {

/// Number of faults per cause of a trip; tests record it in their property "faults".
inline constexpr int kFaultsOfACause = 78;
static_assert(13 * kFaultsOfACause > 1000);

inline const device::HandParameters kLightHand{0.03, 1.0, 100.0, 3.0};
inline const device::HandParameters kFirmHand{0.3, 30.0, 1500.0, 20.0};

/// Position of the hand when the fault occurs.
enum class Place : std::uint8_t { anywhere, free, plate, running_free, running_on_plate };

struct FaultCase {
    std::string tuning_name;
    control::Tuning tuning;
    double servo_hz = 1000.0;
    bool firm = false;
    bool on_plate = false;
    Vector3 start_m{Vector3::Zero()};  ///< where it rests initially
    Vector3 target_m{Vector3::Zero()}; ///< where the hand then moves
    double hand_m_per_s = 0.2;
    std::uint64_t at_tick = 0;

    [[nodiscard]] device::HandParameters hand() const;
    [[nodiscard]] std::string description() const;
};

/// Tunings, rates and hands cycle with the number of the case; all else is random.
[[nodiscard]] FaultCase random_case(std::mt19937 &random, int number, Place place);

[[nodiscard]] double uniform(std::mt19937 &random, double minimum, double maximum);
[[nodiscard]] double log_uniform(std::mt19937 &random, double minimum, double maximum);

} // namespace springdrive::testing

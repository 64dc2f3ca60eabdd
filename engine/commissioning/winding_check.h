// Windings and current sensors, by test pulses on one winding after the other.
//
// A sensor's gain g shows R/g and L/g. L of a motor does not depend on its temperature, and differs
// little between motors of a kind. So one channel whose L differs from that of the two others has a
// sensor with another gain, if the difference is too small to be another winding.
#pragma once

#include "device/core/bench.h"
#include "device/core/device_file.h"
#include "engine/commissioning/finding.h"

#include <array>
#include <span>
#include <vector>

namespace springdrive::commissioning {

/// By which L of one channel may differ from that of the two others, as a share of it. Six
/// deviations of what is measured by the default pulses, see winding_check_test.cpp.
inline constexpr double kSensorGainTolerance = 0.05;

/// By which L may differ from the file's, as a share of it: data sheets give no tolerance.
inline constexpr double kInductanceTolerance = 0.25;

/// Means over all pulses, as the current sensors see them, and deviations of the means.
struct WindingFigures {
    double resistance_Ohm = 0.0;
    double resistance_deviation_Ohm = 0.0;
    double inductance_H = 0.0;
    double inductance_deviation_H = 0.0;
    bool has_reversed_sensor = false;
};

struct WindingReport {
    std::array<WindingFigures, 3> motor;
    std::vector<Finding> findings;
};

/// Motors are taken to be as warm as the air.
/// @param results  of the same order, at least one
[[nodiscard]] WindingReport check_windings(const device::DeviceDescription &device,
                                           std::span<const device::PulseResult> results);

} // namespace springdrive::commissioning

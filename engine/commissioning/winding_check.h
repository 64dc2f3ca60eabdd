// Windings and current sensors, by test pulses on one winding after the other.
//
// A sensor's gain g shows R/g and L/g, and leaves L/R as it is. So one channel whose L differs from
// that of the two others has a sensor with another gain, or a motor with another L: data sheets
// give no tolerance for that, and motors of a kind are assumed to differ by less than
// kGainTolerance. Among two against one, the file's L decides which are named.
#pragma once

#include "device/core/bench.h"
#include "device/core/device_description.h"
#include "engine/commissioning/finding.h"

#include <array>
#include <span>
#include <vector>

namespace springdrive::commissioning {

/// By which L of one channel may differ from that of the two others, as a share of it; and by as
/// many deviations of what was measured.
inline constexpr double kGainTolerance = 0.05;
inline constexpr double kGainDeviations = 6.0;

/// By which L may differ from the file's, as a share of it: data sheets give no tolerance.
inline constexpr double kInductanceTolerance = 0.25;

/// Means over the pulses that were completed, as the current sensors see them, and deviations of
/// the means.
struct WindingFigures {
    double resistance_Ohm = 0.0;
    double resistance_deviation_Ohm = 0.0;
    double inductance_H = 0.0;
    double inductance_deviation_H = 0.0;
    bool has_reversed_sensor = false;

    [[nodiscard]] bool is_measured() const { return resistance_Ohm > 0.0; } // not for NaN
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

// What the work-precision charts are of, and how their makers tell how far they are.
#pragma once

#include "device/core/device_file.h"
#include "engine/control/tuning.h"

#include <functional>

namespace springdrive::charts {

struct ChartSetting {
    device::DeviceDescription device;
    control::Tuning tuning;
    int repeats = 5; ///< how often each time is taken, at least once
};

/// Told how far a chart is, as a share of 1.
using ChartProgress = std::function<void(double share)>;

} // namespace springdrive::charts

// The settings of the speed-accuracy charts, and the progress reports of their makers.
#pragma once

#include "device/core/device_file.h"
#include "engine/control/tuning.h"

#include <functional>

namespace springdrive::charts {

struct ChartSetting {
    device::DeviceDescription device;
    control::Tuning tuning;
    int repeats = 5; ///< how often each time is measured, at least once
};

/// Receives the progress of a chart, from 0 to 1.
using ChartProgress = std::function<void(double share)>;

} // namespace springdrive::charts

#pragma once

#include "engine/lab/charts/chart.h"
#include "tests/support/devices.h"

namespace springdrive::testing {

/// The PHANTOM 1.0, each cost measured once: for tests of errors.
inline charts::ChartSetting quick_setting() {
    charts::ChartSetting setting;
    setting.device = phantom_1_0();
    setting.repeats = 1;
    return setting;
}

} // namespace springdrive::testing

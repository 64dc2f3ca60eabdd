// Calibrations that several tests share.
#pragma once

#include "device/core/device_file.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace springdrive::testing {

/// A calibration of this serial number, with possible numbers.
inline device::Calibration possible_calibration(const std::string &serial) {
    const device::DeviceDescription file = phantom_1_0();
    device::Calibration calibration;
    calibration.serial = serial;
    calibration.kind = "USB";
    calibration.made_at_s = 1'764'000'000;
    for (std::size_t j = 0; j < 3; ++j) {
        for (const device::CalibrationField &field : device::calibration_fields(file, j, 10.0)) {
            calibration.motor[j].*field.value =
                0.4 * field.range.minimum + 0.6 * field.range.maximum;
        }
    }
    return calibration;
}

/// @param share  by which numbers may differ
inline void expect_equal(const device::Calibration &a, const device::Calibration &b,
                         double share = 0.0) {
    EXPECT_EQ(a.serial, b.serial);
    EXPECT_EQ(a.made_at_s, b.made_at_s);
    for (std::size_t j = 0; j < 3; ++j) {
        for (const device::CalibrationField &field : device::calibration_fields({}, j, 0.0)) {
            const double value = b.motor[j].*field.value;
            EXPECT_NEAR(a.motor[j].*field.value, value, share * std::abs(value)) << field.key;
        }
    }
}

} // namespace springdrive::testing

// The checks of tests/device/usb/core_checks.h on the host; device/usb/board/arm/build runs them on
// an emulated Cortex-M4.
#include "tests/device/usb/core_checks.h"

#include <gtest/gtest.h>

namespace springdrive::testing {
namespace {

TEST(CoreChecks, Hold) {
    for (const CoreCheck &check : kCoreChecks) {
        EXPECT_TRUE(check.holds()) << check.name;
    }
    EXPECT_EQ(trial_checksum(), kTrialChecksum);
}

} // namespace
} // namespace springdrive::testing

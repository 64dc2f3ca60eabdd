// Covers engine/servo/safety_status.cpp.
#include "engine/servo/safety_status.h"

#include "device/core/board_faults.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <limits>
#include <set>
#include <string>

namespace springdrive::servo {
namespace {

std::string told(TripCause cause, double measured = 0.0, double limit = 0.0) {
    return description({SafetyState::tripped, cause, measured, limit, 0.0, {}, 0});
}

TEST(SafetyStatus, DescribesTheExceededLimitInDisplayUnits) {
    EXPECT_EQ(told(TripCause::current, 5.568, 5.5), "winding current 5.57 A, limit 5.50 A");
    EXPECT_EQ(told(TripCause::tip_force, 9.0, 8.5), "tip force 9.00 N, limit 8.50 N");
    EXPECT_EQ(told(TripCause::tip_speed, 2.5, 2.0), "tip speed 2.50 m/s, limit 2.00 m/s");
    EXPECT_EQ(told(TripCause::winding_temperature, 100.26, 100.0),
              "winding temperature, upper estimate, 100.3 °C, limit 100.0 °C");
    EXPECT_EQ(told(TripCause::missed_deadlines, 0.051, 0.05),
              "consecutive deadlines missed for 51.0 ms, limit 50.0 ms");
    EXPECT_EQ(told(TripCause::window_silent, 2.001, 2.0),
              "no heartbeat from the window for 2.00 s, limit 2.00 s");
    EXPECT_EQ(told(TripCause::encoder_jump, 0.0123, 0.004),
              "encoder jump at the tip 12.30 mm, limit 4.00 mm");
    EXPECT_EQ(told(TripCause::beyond_stops, 0.0698131700797732, 0.0523598775598299),
              "joint angle beyond its stop by 4.0°, limit 3.0°");
    EXPECT_EQ(told(TripCause::energy, 0.0312, 0.03),
              "energy delivered to the hand 31.2 mJ, limit 30.0 mJ");
    EXPECT_EQ(told(TripCause::voltage, 13.5, 12.0), "sustained e_W 13.5 V, limit 12.0 V");
}

TEST(SafetyStatus, EveryCauseHasItsOwnNameAndText) {
    ASSERT_EQ(kTripCauseNames.size(), static_cast<std::size_t>(TripCause::motor_contradicted) + 1);
    std::set<std::string> names;
    std::set<std::string> words;
    for (std::size_t i = 0; i < kTripCauseNames.size(); ++i) {
        EXPECT_TRUE(names.insert(std::string(kTripCauseNames[i])).second);
        const std::string text = told(static_cast<TripCause>(i), 1.0, 2.0);
        EXPECT_NE(text, "unknown") << i;
        EXPECT_EQ(text.find('\n'), std::string::npos);
        EXPECT_TRUE(words.insert(text).second) << text;
    }
    EXPECT_EQ(kTripCauseNames[static_cast<std::size_t>(TripCause::torn_inputs)], "torn_inputs");
    EXPECT_EQ(kTripCauseNames[static_cast<std::size_t>(TripCause::current)], "current");
    EXPECT_EQ(kTripCauseNames[static_cast<std::size_t>(TripCause::voltage)], "voltage");
    EXPECT_EQ(kTripCauseNames[static_cast<std::size_t>(TripCause::assertion)], "assertion");
}

TEST(SafetyStatus, SaysThatARequestedStopIsHeldWhateverTrippedFirst) {
    SafetyStatus status{SafetyState::tripped, TripCause::tip_speed, 2.5, 2.0, 0.0, {}, 3};
    EXPECT_EQ(description(status),
              "tip speed 2.50 m/s, limit 2.00 m/s; then it was stopped by hand");
    status.cause = TripCause::emergency_stop;
    EXPECT_EQ(description(status), "emergency stop");
    status.cause = TripCause::board_fault;
    status.measured = device::BoardFaults::kStop;
    EXPECT_EQ(description(status).find("hand"), std::string::npos);
}

TEST(SafetyStatus, DescribesNaNAndHugeNumbers) {
    EXPECT_EQ(told(TripCause::tip_force, 1e300, 8.5).find("tip force 1000000"), 0U);
    EXPECT_NE(told(TripCause::tip_force, std::numeric_limits<double>::quiet_NaN(), 8.5).find("nan"),
              std::string::npos);
}

} // namespace
} // namespace springdrive::servo

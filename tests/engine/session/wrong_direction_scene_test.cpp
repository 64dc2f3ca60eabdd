// The scene of the wrong direction, touched by the simulated hand: what the window measures there.
#include "base/degrees.h"
#include "engine/session/session.h"
#include "engine/session/telemetry_history.h"
#include "tests/engine/session/session_fixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

namespace springdrive::session {
namespace {

constexpr double kDepth_m = 0.006; // of the hand's target; presses with 1.3 to 1.8 N
constexpr double kSettles_s = 1.5;

/// A session whose hand presses on the scene's spot.
class PressedSpot {
public:
    /// @param seed  which device of its kind
    explicit PressedSpot(std::uint64_t seed) : session_(options(seed)) {
        session_.start();
        testing::run(session_, 1.2); // the gains rise
        const scene::TouchSpot &spot = *session_.scenes().now().scene.lesson.spot;
        session_.hand().move_to(spot.point_m + 0.012 * spot.normal);
        testing::run(session_, 1.0);
        EXPECT_FALSE(session_.latest().contact.touching);
        session_.hand().move_to(spot.point_m - kDepth_m * spot.normal);
        testing::run(session_, kSettles_s);
    }

    void use(control::MotionMap map) {
        control::Tuning tuning = session_.latest().tuning;
        tuning.map = map;
        session_.tuning().change(tuning, session_.plot_time_s());
        testing::run(session_, kSettles_s);
    }

    /// Of the last second, the least and the largest value of a channel.
    struct Range {
        double min_deg = 180.0;
        double largest_deg = 0.0;
    };
    [[nodiscard]] Range measured(const std::string &channel) const {
        const record::ChannelStore &store = session_.servo().history().store();
        const std::size_t number = *channel_named(channel);
        Range range;
        for (std::uint64_t row = store.end() - 1000; row < store.end(); ++row) {
            const double deg = kDegreesPerRadian * store.value(number, row);
            EXPECT_TRUE(std::isfinite(deg)) << channel; // it touches, with that map
            range.min_deg = std::min(range.min_deg, deg);
            range.largest_deg = std::max(range.largest_deg, deg);
        }
        return range;
    }

    void expect_well() const {
        const servo::ServoSample &now = session_.latest();
        EXPECT_EQ(now.safety.state, servo::SafetyState::running);
        EXPECT_FALSE(now.active_limits.holds_force());
        EXPECT_GT(now.tip_force_N.norm(), 1.0);
        EXPECT_LT(now.tip_force_N.norm(), 3.0);
    }

private:
    static SessionOptions options(std::uint64_t seed) {
        SessionOptions options = testing::scripted("wrong_direction");
        options.plays_script = false;
        options.device_seed = seed;
        return options;
    }

    Session session_;
};

TEST(WrongDirectionSession, TheInverseMapIsBeyond25DegreesAndTheTransposeMapBelow5) {
    for (const std::uint64_t seed : {0, 3, 7, 11}) { // the file's own device, and drawn ones
        SCOPED_TRACE(seed);
        PressedSpot pressed(seed);
        pressed.use(control::MotionMap::inverse);
        pressed.expect_well();
        EXPECT_GT(pressed.measured("inverse_measured_rad").min_deg, 25.0);
        pressed.use(control::MotionMap::transpose);
        pressed.expect_well();
        EXPECT_LT(pressed.measured("transpose_measured_rad").largest_deg, 5.0);
    }
}

} // namespace
} // namespace springdrive::session

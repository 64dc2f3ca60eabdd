// Covers app/plots/trigger.cpp.
#include "app/plots/trigger.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <random>
#include <vector>

namespace springdrive::signals {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The indices of the values that are events.
std::vector<int> events(const TriggerCondition &condition, const std::vector<double> &values) {
    EdgeDetector detector(condition);
    std::vector<int> all;
    for (int i = 0; i < static_cast<int>(values.size()); ++i) {
        if (detector.take(values[static_cast<std::size_t>(i)])) {
            all.push_back(i);
        }
    }
    return all;
}

using Indices = std::vector<int>;

TEST(EdgeDetector, FiresWhereTheLevelIsPassed) {
    const std::vector<double> values{0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0, 3.0, 0.0};
    EXPECT_EQ(events({TriggerEdge::rising, 1.5, 0.0}, values), (Indices{2, 7}));
    EXPECT_EQ(events({TriggerEdge::falling, 1.5, 0.0}, values), (Indices{5, 8}));
    EXPECT_EQ(events({TriggerEdge::either, 1.5, 0.0}, values), (Indices{2, 5, 7, 8}));
}

TEST(EdgeDetector, TheLevelItselfIsLow) {
    const std::vector<double> contact{0.0, 0.0, 1e-9, 5.0, 0.0, 0.0};
    EXPECT_EQ(events({TriggerEdge::rising, 0.0, 0.0}, contact), Indices{2});
    EXPECT_EQ(events({TriggerEdge::falling, 0.0, 0.0}, contact), Indices{4});
    EXPECT_EQ(events({TriggerEdge::rising, 5.0, 0.0}, contact), Indices{});
}

TEST(EdgeDetector, TheFirstValueIsNoEvent) {
    for (const TriggerEdge edge :
         {TriggerEdge::rising, TriggerEdge::falling, TriggerEdge::either, TriggerEdge::change}) {
        for (const double first : {-1.0, 0.0, 1.0, kInfinity}) {
            EXPECT_EQ(events({edge, 0.0, 0.0}, {first}), Indices{});
            EXPECT_EQ(events({edge, 0.0, 0.0}, {kNaN, first}), Indices{});
        }
    }
}

TEST(EdgeDetector, IsArmedAgainByPassingTheHysteresis) {
    // To 8 or less for a rising edge at 10.
    EXPECT_EQ(events({TriggerEdge::rising, 10.0, 2.0}, {9.0, 11.0}), Indices{});
    EXPECT_EQ(events({TriggerEdge::rising, 10.0, 2.0}, {8.0, 11.0, 8.1, 11.0, 8.0, 11.0}),
              (Indices{1, 5}));
    // Above 12 for a falling one.
    EXPECT_EQ(events({TriggerEdge::falling, 10.0, 2.0}, {12.0, 9.0}), Indices{});
    EXPECT_EQ(events({TriggerEdge::falling, 10.0, 2.0}, {12.1, 9.0, 12.0, 9.0, 12.1, 9.0}),
              (Indices{1, 5}));
}

TEST(EdgeDetector, NoiseOnARampFiresOnceIfTheHysteresisIsLarger) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> noise(-0.5, 0.5);
    for (int trial = 0; trial < 50; ++trial) {
        std::vector<double> up;
        std::vector<double> down;
        for (int i = -500; i <= 500; ++i) {
            up.push_back(0.01 * i + noise(random));
            down.push_back(-0.01 * i + noise(random));
        }
        EXPECT_EQ(events({TriggerEdge::rising, 0.0, 1.0}, up).size(), 1U);
        EXPECT_EQ(events({TriggerEdge::falling, 0.0, 1.0}, up).size(), 0U);
        EXPECT_EQ(events({TriggerEdge::either, 0.0, 1.0}, up).size(), 1U);
        EXPECT_EQ(events({TriggerEdge::falling, 0.0, 1.0}, down).size(), 1U);
        EXPECT_EQ(events({TriggerEdge::either, 0.0, 1.0}, down).size(), 1U);
        EXPECT_GT(events({TriggerEdge::rising, 0.0, 0.0}, up).size(), 1U); // the test can fail
    }
}

TEST(EdgeDetector, AnyOtherValueIsAChange) {
    EXPECT_EQ(events({TriggerEdge::change, 99.0, 99.0}, {1.0, 1.0, 2.0, 2.0, 1.0, kInfinity}),
              (Indices{2, 4, 5}));
    EXPECT_EQ(events({TriggerEdge::change, 0.0, 0.0}, {1.0, std::nextafter(1.0, 2.0)}), Indices{1});
    EXPECT_EQ(events({TriggerEdge::change, 0.0, 0.0}, {0.0, -0.0}), Indices{});
}

TEST(EdgeDetector, PassesOverNaN) {
    EXPECT_EQ(events({TriggerEdge::change, 0.0, 0.0}, {1.0, kNaN, 1.0, kNaN, 2.0}), Indices{4});
    EXPECT_EQ(events({TriggerEdge::rising, 0.0, 0.0}, {-1.0, kNaN, 1.0, kNaN, 1.0}), Indices{2});
    EXPECT_EQ(events({TriggerEdge::falling, 0.0, 0.0}, {1.0, kNaN, -1.0, kNaN, -1.0}), Indices{2});
    EXPECT_EQ(events({TriggerEdge::either, 0.0, 0.0}, {kNaN, kNaN}), Indices{});
}

TEST(EdgeDetector, AResetForgetsAllValues) {
    for (const TriggerEdge edge : {TriggerEdge::rising, TriggerEdge::change}) {
        EdgeDetector detector({edge, 0.0, 0.0});
        EXPECT_FALSE(detector.take(-1.0));
        detector.reset();
        EXPECT_FALSE(detector.take(1.0));
        EXPECT_FALSE(detector.take(-1.0) && edge == TriggerEdge::rising);
        EXPECT_TRUE(detector.take(1.0)); // the condition is still the same
    }
}

/// Without any state: value i is an event if it is on the far side, and an earlier one was beyond
/// the hysteresis, with none between them on the far side.
bool is_edge(const std::vector<double> &values, std::size_t i, bool upwards,
             const TriggerCondition &condition) {
    const auto is_far = [&](double value) {
        return upwards ? value > condition.level : value <= condition.level;
    };
    const auto is_near = [&](double value) {
        return upwards ? value <= condition.level - condition.hysteresis
                       : value > condition.level + condition.hysteresis;
    };
    if (!is_far(values[i])) {
        return false;
    }
    for (std::size_t j = i; j-- > 0;) {
        if (is_near(values[j])) {
            return true;
        }
        if (is_far(values[j])) {
            return false;
        }
    }
    return false;
}

bool is_change(const std::vector<double> &values, std::size_t i) {
    for (std::size_t j = i; j-- > 0 && !std::isnan(values[i]);) {
        if (!std::isnan(values[j])) {
            return values[j] != values[i];
        }
    }
    return false;
}

bool is_event(const std::vector<double> &values, std::size_t i, const TriggerCondition &condition) {
    switch (condition.edge) {
    case TriggerEdge::rising:
        return is_edge(values, i, true, condition);
    case TriggerEdge::falling:
        return is_edge(values, i, false, condition);
    case TriggerEdge::either:
        return is_edge(values, i, true, condition) || is_edge(values, i, false, condition);
    case TriggerEdge::change:
        return is_change(values, i);
    }
    return false;
}

/// Small integers, which are often equal to a level, and some that are no numbers.
std::vector<double> random_signal(std::mt19937_64 &random) {
    std::uniform_int_distribution<int> any(-6, 8);
    std::vector<double> values;
    for (int i = 0; i < 60; ++i) {
        const int number = any(random);
        values.push_back(number == 7   ? kNaN
                         : number == 8 ? std::copysign(kInfinity, any(random))
                                       : number);
    }
    return values;
}

TEST(EdgeDetector, FiresAsDefinedOnRandomSignals) {
    std::mt19937_64 random(2);
    for (int trial = 0; trial < 2000; ++trial) {
        const std::vector<double> values = random_signal(random);
        for (const TriggerEdge edge : {TriggerEdge::rising, TriggerEdge::falling,
                                       TriggerEdge::either, TriggerEdge::change}) {
            const TriggerCondition condition{edge, static_cast<double>(trial % 5 - 2),
                                             static_cast<double>(trial % 4)};
            EdgeDetector detector(condition);
            for (std::size_t i = 0; i < values.size(); ++i) {
                ASSERT_EQ(detector.take(values[i]), is_event(values, i, condition))
                    << trial << ' ' << i;
            }
        }
    }
}

TEST(EdgeDetectorDeathTest, NeedsAHysteresisThatIsNotNegative) {
    EXPECT_DEATH(EdgeDetector({TriggerEdge::rising, 0.0, -1e-300}), "hysteresis >= 0.0");
    EXPECT_DEATH(EdgeDetector({TriggerEdge::rising, 0.0, kNaN}), "hysteresis >= 0.0");
}

TEST(Trigger, CollectsUntilTheTimeAfterTheEventIsOver) {
    Trigger trigger({TriggerMode::single, 1.0, 2.0, 0.0});
    trigger.take(9.0, false);
    EXPECT_EQ(trigger.state(), TriggerState::waiting);
    trigger.take(10.0, true);
    EXPECT_EQ(trigger.state(), TriggerState::collecting);
    EXPECT_FALSE(trigger.window());
    trigger.take(11.75, false);
    EXPECT_EQ(trigger.state(), TriggerState::collecting);
    trigger.take(12.0, false);
    EXPECT_EQ(trigger.state(), TriggerState::complete);
    ASSERT_TRUE(trigger.window());
    EXPECT_EQ(trigger.window()->from_s, 9.0);
    EXPECT_EQ(trigger.window()->to_s, 12.0);
}

TEST(Trigger, WithoutTimeAfterTheEventIsCompleteAtOnce) {
    Trigger trigger({TriggerMode::single, 1.0, 0.0, 0.0});
    trigger.take(5.0, true);
    ASSERT_TRUE(trigger.window());
    EXPECT_EQ(trigger.window()->to_s, 5.0);
}

TEST(Trigger, AnEventIsValidHoweverEarlyItIs) {
    Trigger trigger({TriggerMode::single, 1.0, 0.5, 0.0});
    trigger.take(0.0, true);
    trigger.take(0.5, false);
    ASSERT_TRUE(trigger.window());
    EXPECT_EQ(trigger.window()->from_s, -1.0); // less is shown
}

TEST(Trigger, EventsWhileItCollectsOrIsCompleteAreIgnored) {
    for (const TriggerMode mode : {TriggerMode::single, TriggerMode::repeating}) {
        Trigger trigger({mode, 0.0, 2.0, 0.0});
        for (int time_s = 0; time_s <= 10; ++time_s) {
            trigger.take(time_s, true);
        }
        ASSERT_TRUE(trigger.window());
        EXPECT_EQ(trigger.window()->from_s, 0.0);
    }
}

TEST(Trigger, OnlyARepeatingOneProceeds) {
    for (const TriggerMode mode : {TriggerMode::single, TriggerMode::repeating}) {
        Trigger trigger({mode, 0.0, 1.0, 0.0});
        trigger.take(0.0, true);
        trigger.proceed(); // too early
        EXPECT_EQ(trigger.state(), TriggerState::collecting);
        trigger.take(1.0, false);
        trigger.proceed();
        EXPECT_EQ(trigger.state(),
                  mode == TriggerMode::single ? TriggerState::complete : TriggerState::waiting);
        EXPECT_EQ(trigger.window().has_value(), mode == TriggerMode::single);
        trigger.take(2.0, true);
        trigger.take(3.0, false);
        EXPECT_EQ(trigger.window()->to_s, mode == TriggerMode::single ? 1.0 : 3.0);
    }
}

TEST(Trigger, ArmsAgainFromEveryState) {
    for (const int ticks : {0, 1, 2, 3}) {
        Trigger trigger({TriggerMode::single, 0.0, 1.5, 100.0});
        for (int i = 0; i < ticks; ++i) {
            trigger.take(10.0 + i, true);
        }
        trigger.arm();
        EXPECT_EQ(trigger.state(), TriggerState::waiting);
        EXPECT_FALSE(trigger.window());
        trigger.take(3.0, true); // whatever the hold-off, and earlier than before
        trigger.take(4.5, false);
        ASSERT_TRUE(trigger.window()) << ticks;
        EXPECT_EQ(trigger.window()->to_s, 4.5);
    }
}

TEST(Trigger, TheHoldOffIsFromEventToEvent) {
    Trigger trigger({TriggerMode::repeating, 0.0, 1.0, 5.0});
    std::vector<double> found_s;
    for (int time_s = 0; time_s < 20; ++time_s) {
        trigger.take(time_s, time_s != 5); // one is missed just when it is over
        if (const auto window = trigger.window()) {
            found_s.push_back(window->from_s);
            trigger.proceed();
        }
    }
    EXPECT_EQ(found_s, (std::vector<double>{0.0, 6.0, 11.0, 16.0}));
}

/// Every event that may be acquired is, and no other: the first one since both the previous
/// window's last tick and the end of the hold-off.
TEST(Trigger, AcquiresTheFirstPossibleEventOfRandomOnes) {
    std::mt19937_64 random(3);
    std::uniform_int_distribution<int> ticks(0, 12);
    for (int trial = 0; trial < 500; ++trial) {
        const int post = ticks(random);
        const int holdoff = 2 * ticks(random);
        std::vector<bool> fired(300);
        std::generate(fired.begin(), fired.end(), [&] { return ticks(random) == 0; });
        std::vector<double> expected_s;
        for (int i = 0; i + post < 300; ++i) {
            if (fired[static_cast<std::size_t>(i)]) {
                expected_s.push_back(i);
                i += std::max(post, holdoff - 1);
            }
        }

        Trigger trigger(
            {TriggerMode::repeating, 7.0, static_cast<double>(post), static_cast<double>(holdoff)});
        std::vector<double> found_s;
        for (int i = 0; i < 300; ++i) {
            trigger.take(i, fired[static_cast<std::size_t>(i)]);
            if (const auto window = trigger.window()) {
                EXPECT_EQ(window->to_s, i);
                EXPECT_EQ(window->to_s - window->from_s, 7.0 + post);
                found_s.push_back(window->from_s + 7.0);
                trigger.proceed();
            }
        }
        EXPECT_EQ(found_s, expected_s) << trial;
    }
}

TEST(TriggerDeathTest, NeedsTimesThatAreNotNegative) {
    EXPECT_DEATH(Trigger({TriggerMode::single, -1.0, 0.0, 0.0}), "pre_s >= 0.0");
    EXPECT_DEATH(Trigger({TriggerMode::single, 0.0, kNaN, 0.0}), "post_s >= 0.0");
    EXPECT_DEATH(Trigger({TriggerMode::single, 0.0, 0.0, -1.0}), "holdoff_s >= 0.0");
}

} // namespace
} // namespace springdrive::signals

// Covers device/core/faults: the schedule, and the texts.
#include "device/core/faults.h"

#include "base/input_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace springdrive::device {
namespace {

/// Times in quarters of a tick.
struct Span {
    std::uint64_t begin = 0;
    std::uint64_t end = 0;
};

/// From the first tick at or after the begin to the last one before the end.
bool acts(const Span &span, std::uint64_t tick) {
    return 4 * tick >= span.begin && 4 * tick < span.end;
}

TEST(FaultInjector, ActsAtEachTickAsTheTimesSay) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937_64 random(seed);
        const auto drawn = [&random](std::uint64_t below) { return random() % below; };
        FaultInjector injector(1000.0);
        std::vector<Span> spans; // by the channels of the faults
        std::vector<std::size_t> before;
        for (std::uint64_t tick = 0; tick < 400; ++tick) {
            if (drawn(40) == 0) {
                const std::uint64_t begin = drawn(1600); // may be in the past
                spans.push_back({begin, begin + drawn(400)});
                Fault fault;
                fault.kind = FaultKind::stuck_encoder;
                fault.channel = spans.size() - 1;
                fault.begin_s = static_cast<double>(spans.back().begin) / 4000.0;
                fault.end_s = static_cast<double>(spans.back().end) / 4000.0;
                injector.add(fault);
            }
            const bool has_changed = injector.update(tick);
            std::vector<std::size_t> expected;
            for (std::size_t channel = 0; channel < spans.size(); ++channel) {
                if (acts(spans[channel], tick)) {
                    expected.push_back(channel);
                }
            }
            std::vector<std::size_t> found;
            for (const Fault &fault : injector.active()) {
                found.push_back(fault.channel);
            }
            ASSERT_EQ(found, expected) << "tick " << tick;
            const bool begins = std::ranges::any_of(expected, [&](std::size_t channel) {
                return std::ranges::find(before, channel) == before.end();
            });
            ASSERT_TRUE(has_changed || expected == before) << tick;
            ASSERT_TRUE(!has_changed || injector.has_begun(FaultKind::stuck_encoder) == begins)
                << tick;
            ASSERT_FALSE(injector.update(tick)) << tick; // nothing since
            before = expected;
        }
    }
}

TEST(FaultTexts, AreRead) {
    const Fault drop = parse_fault("drop:in:0.01");
    EXPECT_EQ(drop.kind, FaultKind::drop);
    EXPECT_EQ(drop.direction, Direction::in);
    EXPECT_EQ(drop.share, 0.01);
    EXPECT_EQ(drop.begin_s, 0.0);
    EXPECT_TRUE(std::isinf(drop.end_s));
    const Fault delay = parse_fault("delay:out:#7:2.5@1-2.5");
    EXPECT_EQ(delay.packet, 7U);
    EXPECT_EQ(delay.periods, 2.5);
    EXPECT_EQ(delay.begin_s, 1.0);
    EXPECT_EQ(delay.end_s, 2.5);
    EXPECT_EQ(parse_fault("stuck-encoder:2").channel, 1U);
    EXPECT_EQ(parse_fault("crossed-motors:3:1").other_channel, 0U);
    EXPECT_EQ(parse_fault("unplug@3.5").begin_s, 3.5);
    EXPECT_EQ(parse_fault("lost-counts:2:0.1").share, 0.1);
    EXPECT_EQ(parse_fault("sensor-gain:3:1.1").size[0], 1.1);
    EXPECT_EQ(parse_fault("sensor-gain:3:1.1").channel, 2U);
    EXPECT_EQ(parse_fault("brown-out:9.5").size[0], 9.5);
    for (const FaultName &known : kFaultNames) {
        EXPECT_NE(fault_usage().find(std::string(known.name)), std::string::npos);
    }
}

TEST(FaultTexts, AreRefusedWithAReason) {
    const auto error = [](const char *text) {
        return error_text_of([&] { static_cast<void>(parse_fault(text)); });
    };
    EXPECT_NE(error("dorp:in").find("nearest name is 'drop'"), std::string::npos);
    EXPECT_EQ(error("drop:up"), "fault 'drop:up': 'up' is no direction; write "
                                "drop:in|out[:SHARE|:#NUMBER][@BEGIN[-END]]");
    EXPECT_NE(error("drop:in:1.5").find("from 0 to 1"), std::string::npos);
    EXPECT_NE(error("drop:in:nan").find("share"), std::string::npos);
    for (const char *wrong : {"",
                              ":",
                              "@1",
                              "drop",
                              "drop:in:",
                              "drop:in:#0",
                              "drop:in:#x",
                              "drop:in:0.1:2",
                              "delay:in:0.1:x",
                              "stuck-encoder",
                              "stuck-encoder:0",
                              "stuck-encoder:4",
                              "stuck-encoder:1:2",
                              "crossed-sensors:2:2",
                              "crossed-sensors:2",
                              "brown-out",
                              "brown-out:-1",
                              "hot-stage",
                              "stop:1",
                              "unplug@",
                              "unplug@-1",
                              "unplug@2-1",
                              "unplug@1-",
                              "unplug@inf",
                              "unplug@nan",
                              "stop@1@2"}) {
        EXPECT_NE(error(wrong), "") << wrong;
    }
}

} // namespace
} // namespace springdrive::device

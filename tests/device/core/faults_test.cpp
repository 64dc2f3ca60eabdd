// Covers the schedule of device/core/faults.h.
#include "device/core/faults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
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

} // namespace
} // namespace springdrive::device

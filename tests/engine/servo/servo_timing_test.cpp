// Covers engine/servo/servo_timing.h.
#include "engine/servo/servo_timing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

namespace springdrive::servo {
namespace {

using Nanoseconds = std::int64_t;

/// Time of deadline n at an integer rate, in integer arithmetic: the nearest nanosecond.
Nanoseconds exact_ns(std::int64_t n, std::int64_t rate_hz) {
    const std::int64_t rest = n % rate_hz; // in fractions of a second
    return n / rate_hz * 1'000'000'000 + (2'000'000'000 * rest + rate_hz) / (2 * rate_hz);
}

/// A simple reference: the outcome of every deadline, found by iterating over them.
struct Reference {
    explicit Reference(std::int64_t rate) : rate_hz(rate) {}

    [[nodiscard]] Nanoseconds due_ns() const { return exact_ns(next, rate_hz); }

    /// The thread wakes: it serves the last deadline that has passed; earlier ones are missed.
    void begin(Nanoseconds now_ns) {
        while (exact_ns(next + 1, rate_hz) <= now_ns) {
            ++next;
            ++missed;
        }
        served.push_back(next);
        in_a_row = missed == 0 ? 0 : in_a_row + missed;
        total += missed;
    }

    /// The tick ends: deadlines that passed meanwhile are missed, and it waits for the next one.
    void end(Nanoseconds now_ns) {
        missed = 0;
        ++next;
        while (exact_ns(next, rate_hz) < now_ns) {
            ++next;
            ++missed;
        }
    }

    std::int64_t rate_hz;
    std::int64_t next = 1;
    std::int64_t missed = 0;
    std::int64_t in_a_row = 0;
    std::int64_t total = 0;
    std::vector<std::int64_t> served;
};

/// Not within a nanosecond of a deadline, where rounding may decide.
Nanoseconds off_deadlines(Nanoseconds now_ns, std::int64_t rate_hz) {
    const std::int64_t n = now_ns * rate_hz / 1'000'000'000;
    for (const std::int64_t near : {n, n + 1}) {
        if (std::abs(now_ns - exact_ns(near, rate_hz)) <= 1) {
            return exact_ns(near, rate_hz) + 2;
        }
    }
    return now_ns;
}

/// Mostly a fraction of a period, sometimes many periods.
Nanoseconds any_delay(std::mt19937_64 &random, double period_ns, double often) {
    std::uniform_real_distribution<double> one(0.0, 1.0);
    if (one(random) > often) {
        return static_cast<Nanoseconds>(0.3 * period_ns * one(random));
    }
    return static_cast<Nanoseconds>(period_ns * 5.0 * one(random) * one(random));
}

TEST(Deadlines, MatchASimpleReference) {
    std::mt19937_64 random(6);
    for (const std::int64_t rate_hz : {250, 300, 1000, 3000, 7000, 10'000}) {
        for (const double often : {0.0, 0.02, 0.5}) {
            Deadlines deadlines(static_cast<double>(rate_hz));
            Reference reference(rate_hz);
            const double period_ns = 1e9 / static_cast<double>(rate_hz);
            std::int64_t counted = 0;
            Nanoseconds now_ns = 0;
            for (int tick = 0; tick < 5000; ++tick) {
                ASSERT_EQ(deadlines.next_ns(), reference.due_ns());
                now_ns = std::max(now_ns, reference.due_ns());
                now_ns = off_deadlines(now_ns + any_delay(random, period_ns, often), rate_hz);
                deadlines.begin(now_ns);
                reference.begin(now_ns);
                ASSERT_EQ(deadlines.missed(), reference.missed) << rate_hz << ' ' << tick;
                ASSERT_EQ(deadlines.missed_in_a_row(), reference.in_a_row);
                counted += deadlines.missed();
                now_ns = off_deadlines(now_ns + any_delay(random, period_ns, often), rate_hz);
                deadlines.end(now_ns);
                reference.end(now_ns);
            }
            // Never two ticks for one deadline, and each is either served or missed, once.
            const std::vector<std::int64_t> &served = reference.served;
            EXPECT_EQ(std::adjacent_find(served.begin(), served.end(), std::greater_equal<>()),
                      served.end());
            EXPECT_EQ(static_cast<std::int64_t>(served.size()) + counted, served.back());
            EXPECT_EQ(counted > 0, often > 0.0);
        }
    }
}

TEST(Deadlines, DoNotDriftOverAHundredMillionTicks) {
    // Skips ahead by long sleeps: the deadlines there are exact to the nanosecond.
    for (const std::int64_t rate_hz : {250, 3000, 7000, 9999, 10'000}) {
        Deadlines deadlines(static_cast<double>(rate_hz));
        for (std::int64_t n = 9'999'999; n <= 100'000'000; n += 9'999'999) {
            const Nanoseconds now_ns = exact_ns(n, rate_hz) + 2;
            deadlines.begin(now_ns);
            deadlines.end(now_ns + 1);
            ASSERT_EQ(deadlines.next_ns(), exact_ns(n + 1, rate_hz)) << rate_hz << ' ' << n;
        }
    }
}

TEST(Deadlines, NoneIsMissedWhileTicksAreInTime) {
    // Woken exactly on time, for as many ticks as a test can run.
    Deadlines deadlines(3000.0);
    for (std::int64_t n = 1; n <= 3'000'000; ++n) {
        const Nanoseconds due_ns = deadlines.next_ns();
        ASSERT_EQ(due_ns, exact_ns(n, 3000));
        deadlines.begin(due_ns);
        ASSERT_EQ(deadlines.missed(), 0U);
        deadlines.end(due_ns + 50'000);
    }
}

TEST(Deadlines, ATickMayTakeAtMostItsWholePeriod) {
    const auto missed_after = [](Nanoseconds duration_ns) {
        Deadlines deadlines(1000.0);
        deadlines.begin(1'000'000);
        deadlines.end(1'000'000 + duration_ns);
        deadlines.begin(deadlines.next_ns());
        return deadlines.missed();
    };
    EXPECT_EQ(missed_after(999'999), 0U);
    EXPECT_EQ(missed_after(1'000'000), 0U);
    EXPECT_EQ(missed_after(1'000'002), 1U);
    EXPECT_EQ(missed_after(2'000'002), 2U);
}

TEST(DurationHistogram, QuantilesAreWithinABinOfTheTrueOnes) {
    std::mt19937_64 random(10);
    std::lognormal_distribution<double> duration(-11.0, 1.5);
    std::vector<double> all;
    DurationHistogram histogram;
    for (int i = 0; i < 20'000; ++i) {
        all.push_back(duration(random));
        histogram.add(all.back());
    }
    std::sort(all.begin(), all.end());
    for (const double fraction : {0.01, 0.5, 0.99, 0.999}) {
        const double truth = all[static_cast<std::size_t>(std::ceil(fraction * 20'000.0)) - 1];
        EXPECT_NEAR(std::log2(histogram.quantile_s(fraction) / truth), 0.0, 1.0 / 64.0);
    }
    EXPECT_EQ(histogram.longest_s(), all.back());
    EXPECT_EQ(histogram.quantile_s(1.0), all.back());
    EXPECT_EQ(histogram.count(), 20'000U);
}

TEST(DurationHistogram, HandlesEmptyZeroAndInfinite) {
    DurationHistogram histogram;
    EXPECT_EQ(histogram.quantile_s(0.99), 0.0);
    EXPECT_EQ(histogram.mean_s(), 0.0);
    histogram.add(0.0);
    histogram.add(1e9);
    EXPECT_EQ(histogram.count(), 2U);
    EXPECT_EQ(histogram.quantile_s(1.0), 1e9);
}

TEST(ServoStatistics, AccumulatesTheSamples) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> duration_s(1e-6, 1e-3);
    ServoStatistics statistics;
    std::vector<double> period_s;
    std::vector<double> lateness_s;
    double read_s = 0.0;
    double longest_compute_s = 0.0;
    std::uint64_t missed = 0;
    constexpr int kTicks = 2000;
    for (int tick = 0; tick < kTicks; ++tick) {
        ServoSample sample;
        sample.missed_deadlines = static_cast<std::uint32_t>(random() % 3);
        missed += sample.missed_deadlines;
        if (tick > 0) { // the first has no predecessor
            sample.period_s = duration_s(random);
            period_s.push_back(sample.period_s);
        }
        sample.lateness_s = duration_s(random);
        lateness_s.push_back(sample.lateness_s);
        sample.read_s = duration_s(random);
        read_s += sample.read_s;
        sample.compute_s = duration_s(random);
        longest_compute_s = std::max(longest_compute_s, sample.compute_s);
        statistics.add(sample);
    }
    EXPECT_EQ(statistics.ticks(), kTicks);
    EXPECT_EQ(statistics.missed_deadlines(), missed);
    EXPECT_EQ(statistics.period().count(), kTicks - 1);
    EXPECT_EQ(statistics.period().longest_s(), *std::max_element(period_s.begin(), period_s.end()));
    EXPECT_EQ(statistics.lateness().longest_s(),
              *std::max_element(lateness_s.begin(), lateness_s.end()));
    EXPECT_NEAR(statistics.read().mean_s(), read_s / kTicks, 1e-12);
    EXPECT_EQ(statistics.compute().longest_s(), longest_compute_s);
    std::sort(lateness_s.begin(), lateness_s.end());
    EXPECT_NEAR(std::log2(statistics.lateness().quantile_s(0.5) / lateness_s[kTicks / 2 - 1]), 0.0,
                1.0 / 64.0);
}

TEST(ServoStatistics, HaveNoTimesInLockstep) {
    ServoStatistics statistics;
    for (int tick = 0; tick < 10; ++tick) {
        statistics.add(ServoSample{});
    }
    EXPECT_EQ(statistics.ticks(), 10U);
    EXPECT_EQ(statistics.missed_deadlines(), 0U);
    EXPECT_EQ(statistics.period().count(), 0U);
    EXPECT_EQ(statistics.lateness().count(), 0U);
    EXPECT_EQ(statistics.read().count(), 0U);
    EXPECT_EQ(statistics.compute().count(), 0U);
}

} // namespace
} // namespace springdrive::servo

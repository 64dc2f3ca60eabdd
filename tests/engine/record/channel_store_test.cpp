// Covers engine/record/channel_store.cpp.
#include "engine/record/channel_store.h"

#include "tests/support/cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <utility>
#include <vector>

namespace springdrive::record {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::uint64_t kChunk = ChannelStore::kRowsPerChunk;
constexpr std::size_t kUnbounded = std::size_t{1} << 40U;

std::uint64_t bits_of(double value) { return std::bit_cast<std::uint64_t>(value); }

std::uint64_t random_up_to(std::uint64_t largest, std::mt19937_64 &random) {
    return random() % (largest + 1);
}

/// Every row ever added, of which the store keeps the newest.
struct AllRows {
    std::vector<double> times_s;
    std::vector<std::vector<double>> rows;

    void add_to(ChannelStore &store, double time_s, std::vector<double> row) {
        store.add(time_s, row);
        times_s.push_back(time_s);
        rows.push_back(std::move(row));
    }
};

/// One channel's values: of a kind that varies from stretch to stretch.
class RandomChannel {
public:
    double next(std::mt19937_64 &random) {
        if (left_ == 0) {
            left_ = 1 + random_up_to(3 * kChunk, random);
            kind_ = static_cast<Kind>(random_up_to(static_cast<std::uint64_t>(Kind::bits), random));
            constant_ = value_of(Kind::hard, random);
        }
        --left_;
        return value_of(kind_, random);
    }

private:
    enum class Kind : std::uint8_t {
        constant,
        absent,
        integer,
        single_precision,
        double_precision,
        gaps,
        hard,
        bits
    };

    [[nodiscard]] double value_of(Kind kind, std::mt19937_64 &random) const {
        using Limits = std::numeric_limits<double>;
        using FloatLimits = std::numeric_limits<float>;
        static const std::vector<double> hard{
            0.0,
            -0.0,
            0.1,
            1.0,
            kNone,
            -kNone,
            kInfinity,
            -kInfinity,
            Limits::denorm_min(),
            Limits::max(),
            FloatLimits::max(),
            std::nextafter(static_cast<double>(FloatLimits::max()), kInfinity),
            FloatLimits::denorm_min(),
            0.5 * static_cast<double>(FloatLimits::denorm_min()),
        };
        const double number = std::normal_distribution<double>()(random);
        switch (kind) {
        case Kind::constant:
            return constant_;
        case Kind::absent:
            return kNone;
        case Kind::integer:
            return std::round(10.0 * number);
        case Kind::single_precision:
            return static_cast<float>(number);
        case Kind::double_precision:
            return number;
        case Kind::gaps: // blocks without a number are common
            return random_up_to(100, random) == 0 ? number : kNone;
        case Kind::hard:
            return hard[random_up_to(hard.size() - 1, random)];
        case Kind::bits:
            break;
        }
        return std::bit_cast<double>(random());
    }

    Kind kind_ = Kind::constant;
    std::uint64_t left_ = 0;
    double constant_ = 0.0;
};

class RandomRows {
public:
    RandomRows(std::size_t channels, std::uint64_t seed) : random_(seed), channels_(channels) {}

    /// Several rows can be at the same time.
    void add(std::uint64_t count, ChannelStore &store, AllRows &all) {
        std::uniform_real_distribution<double> period_s(0.0, 1e-3);
        for (std::uint64_t i = 0; i < count; ++i) {
            time_s_ += random_up_to(3, random_) == 0 ? 0.0 : period_s(random_);
            std::vector<double> row;
            for (RandomChannel &channel : channels_) {
                row.push_back(channel.next(random_));
            }
            all.add_to(store, time_s_, std::move(row));
        }
    }

    std::mt19937_64 &random() { return random_; }

private:
    std::mt19937_64 random_;
    std::vector<RandomChannel> channels_;
    double time_s_ = -1.0;
};

void expect_same_values(const ChannelStore &store, const AllRows &all) {
    ASSERT_EQ(store.end(), all.rows.size());
    ASSERT_LE(store.begin(), store.end());
    ASSERT_EQ(store.is_empty(), store.begin() == store.end());
    for (std::uint64_t row = store.begin(); row < store.end(); ++row) {
        ASSERT_EQ(store.time_s(row), all.times_s[row]) << row;
        for (std::size_t channel = 0; channel < store.channels(); ++channel) {
            ASSERT_EQ(bits_of(store.value(channel, row)), bits_of(all.rows[row][channel]))
                << "channel " << channel << ", row " << row;
        }
    }
}

void expect_same_range(const ChannelStore &store, const AllRows &all, std::size_t channel,
                       std::uint64_t from, std::uint64_t to) {
    SCOPED_TRACE(::testing::Message() << "channel " << channel << ", rows " << from << " to " << to
                                      << " of " << store.begin() << " to " << store.end());
    std::vector<double> copied{1.0, 2.0};
    store.copy(channel, from, to, copied);
    ASSERT_EQ(copied.size(), to - from);
    std::vector<double> numbers;
    for (std::uint64_t row = from; row < to; ++row) {
        const double value = all.rows[row][channel];
        ASSERT_EQ(bits_of(copied[row - from]), bits_of(value)) << row;
        if (!std::isnan(value)) {
            numbers.push_back(value);
        }
    }
    const ChannelStore::Extremes extremes = store.extremes(channel, from, to);
    ASSERT_EQ(extremes.is_empty(), numbers.empty());
    if (numbers.empty()) {
        ASSERT_TRUE(std::isnan(extremes.minimum) && std::isnan(extremes.maximum));
    } else {
        ASSERT_EQ(extremes.minimum, *std::ranges::min_element(numbers));
        ASSERT_EQ(extremes.maximum, *std::ranges::max_element(numbers));
    }
}

/// Random ranges: any, short, empty, and with ends at or next to those of blocks and chunks.
void expect_same_ranges(const ChannelStore &store, const AllRows &all, std::mt19937_64 &random) {
    const std::uint64_t kept = store.end() - store.begin();
    const auto random_end = [&] {
        const std::uint64_t any = random_up_to(kept, random);
        const std::uint64_t nearby = any / 64 * 64 + random_up_to(2, random);
        return store.begin() + (random_up_to(1, random) == 0 ? any : std::min(nearby, kept));
    };
    for (int i = 0; i < 100; ++i) {
        const std::uint64_t a = random_end();
        const std::uint64_t b = random_up_to(1, random) == 0
                                    ? random_end()
                                    : std::min(a + random_up_to(130, random), store.end());
        const std::size_t channel = random_up_to(store.channels() - 1, random);
        expect_same_range(store, all, channel, std::min(a, b), std::max(a, b));
    }
    expect_same_range(store, all, 0, store.begin(), store.end());
}

void expect_same_row_at(const ChannelStore &store, const AllRows &all, double time_s) {
    std::uint64_t expected = store.begin();
    while (expected < store.end() && all.times_s[expected] < time_s) {
        ++expected;
    }
    ASSERT_EQ(store.row_at(time_s), expected) << time_s << " s";
    const bool is_of_the_row = expected < store.end() && all.times_s[expected] == time_s;
    const std::uint64_t before = is_of_the_row ? expected : expected - 1;
    ASSERT_EQ(store.row_shown_at(time_s),
              expected == store.end() || (expected == store.begin() && !is_of_the_row)
                  ? std::nullopt
                  : std::optional(before))
        << time_s << " s";
}

void expect_same_rows_at(const ChannelStore &store, const AllRows &all, std::mt19937_64 &random) {
    expect_same_row_at(store, all, -kInfinity);
    expect_same_row_at(store, all, kInfinity);
    for (int i = 0; i < 40 && !store.is_empty(); ++i) {
        const std::uint64_t row =
            store.begin() + random_up_to(store.end() - store.begin() - 1, random);
        const double time_s = store.time_s(row);
        expect_same_row_at(store, all, time_s);
        expect_same_row_at(store, all, std::nextafter(time_s, -kInfinity));
        expect_same_row_at(store, all, std::nextafter(time_s, kInfinity));
    }
}

void expect_same(const ChannelStore &store, const AllRows &all, std::mt19937_64 &random) {
    expect_same_values(store, all);
    expect_same_ranges(store, all, random);
    expect_same_rows_at(store, all, random);
}

TEST(ChannelStore, ReturnsWhatWasAdded) {
    const std::vector<std::uint64_t> ends{0, 1, kChunk - 1, kChunk, kChunk + 1, 3 * kChunk};
    for (int seed = 0; seed < testing::cases(80, 5000); ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        std::mt19937_64 random(static_cast<std::uint64_t>(seed));
        const std::size_t channels = 1 + random_up_to(19, random);
        ChannelStore store(channels, kUnbounded);
        AllRows all;
        RandomRows rows(channels, random());
        rows.add(seed < static_cast<int>(ends.size()) ? ends[static_cast<std::size_t>(seed)]
                                                      : random_up_to(4 * kChunk, random),
                 store, all);
        EXPECT_EQ(store.begin(), 0U);
        EXPECT_EQ(store.channels(), channels);
        expect_same(store, all, rows.random());
    }
}

/// Against a store without a bound that holds the kept rows alone, and one with a chunk more.
TEST(ChannelStore, DropsTheOldestChunksAtTheBoundAndNoMore) {
    std::uint64_t dropped = 0;
    for (int seed = 0; seed < testing::cases(30, 1000); ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        std::mt19937_64 random(static_cast<std::uint64_t>(seed));
        const std::size_t channels = 1 + random_up_to(7, random);
        AllRows all;
        RandomRows rows(channels, random());
        ChannelStore unbounded(channels, kUnbounded);
        rows.add(6 * kChunk + 7, unbounded, all);
        const auto bytes_of = [&](std::uint64_t from, std::uint64_t to) {
            ChannelStore part(channels, kUnbounded);
            for (std::uint64_t row = from; row < to; ++row) {
                part.add(all.times_s[row], all.rows[row]);
            }
            return part.bytes();
        };
        // Half of the bounds are exactly what some chunks take.
        const std::size_t exactly = bytes_of((1 + random_up_to(4, random)) * kChunk, 6 * kChunk);
        const std::size_t max_bytes =
            seed % 2 == 0 ? exactly : (channels + 1) * random_up_to(50'000, random);
        ChannelStore store(channels, max_bytes);
        for (std::uint64_t row = 0; row < all.rows.size(); ++row) {
            store.add(all.times_s[row], all.rows[row]);
            if (store.end() % kChunk != 0) {
                continue;
            }
            ASSERT_EQ(store.begin() % kChunk, 0U);
            ASSERT_EQ(store.bytes(), bytes_of(store.begin(), store.end()));
            if (store.bytes() > max_bytes) {
                ASSERT_EQ(store.end() - store.begin(), kChunk);
                ASSERT_LE(store.bytes(), (channels + 1) * 17 * 1024);
            }
            if (store.begin() > 0) {
                ++dropped;
                ASSERT_GE(store.end() - store.begin(), kChunk);
            }
        }
        if (seed % 2 == 0) {
            EXPECT_EQ(store.bytes(), exactly);
        } else if (store.begin() > 0) {
            EXPECT_GT(bytes_of(store.begin() - kChunk, 6 * kChunk), max_bytes);
        }
        expect_same(store, all, rows.random());
    }
    EXPECT_GT(dropped, 50U);
}

TEST(ChannelStore, SnapshotKeepsItsRowsWhileTheOriginalGoesOn) {
    for (int seed = 0; seed < testing::cases(30, 1000); ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        std::mt19937_64 random(static_cast<std::uint64_t>(seed));
        const std::size_t channels = 1 + random_up_to(7, random);
        // Enough for about two chunks, so that the original drops all that it shares.
        ChannelStore store(channels, channels * 25'000);
        AllRows all;
        RandomRows rows(channels, random());
        rows.add(random_up_to(3 * kChunk, random), store, all);
        const ChannelStore snapshot = store;
        const AllRows all_then = all;
        rows.add(random_up_to(4 * kChunk, random), store, all);
        expect_same(snapshot, all_then, random);
        expect_same(store, all, random);

        // A copy of the snapshot goes on in its own way.
        ChannelStore branch = snapshot;
        AllRows all_of_branch = all_then;
        const double from_s = all_then.times_s.empty() ? 0.0 : all_then.times_s.back();
        for (std::uint64_t i = 0; i < 2 * kChunk; ++i) {
            all_of_branch.add_to(branch, from_s, std::vector<double>(channels, 7.0));
        }
        store.clear();
        expect_same(branch, all_of_branch, random);
        expect_same(snapshot, all_then, random);
    }
}

TEST(ChannelStore, ClearingContinuesTheNumberingAndAllowsEarlierTimes) {
    const std::uint64_t count = 2 * kChunk + 5;
    ChannelStore store(1, kUnbounded);
    const std::size_t empty_bytes = store.bytes();
    const auto fill = [&] {
        for (std::uint64_t row = 0; row < count; ++row) {
            store.add(static_cast<double>(row), std::vector<double>{-static_cast<double>(row)});
        }
    };
    fill();
    store.clear();
    EXPECT_TRUE(store.is_empty());
    EXPECT_EQ(store.begin(), count);
    EXPECT_EQ(store.end(), count);
    EXPECT_EQ(store.bytes(), empty_bytes);
    EXPECT_EQ(store.row_at(0.0), count);
    EXPECT_TRUE(store.extremes(0, count, count).is_empty());
    fill();
    EXPECT_EQ(store.begin(), count);
    EXPECT_EQ(store.end(), 2 * count);
    EXPECT_EQ(store.row_at(1500.0), count + 1500);
    EXPECT_EQ(store.value(0, count + 1500), -1500.0);
    EXPECT_EQ(store.extremes(0, count + 1000, count + 1500).minimum, -1499.0);
}

/// Of 190 channels, 130 keep their value: settings, limits, states. 20 are small integers: counts,
/// flags; 40 are measured or computed. A row of 191 doubles, with its time, has 1528 bytes.
TEST(ChannelStore, KeepsFiveMinutesOfTelemetryAt1kHzIn130MB) {
    constexpr std::size_t kChannels = 190;
    std::mt19937_64 random(1);
    std::normal_distribution<double> number;
    std::vector<double> row(kChannels, 0.1);
    ChannelStore store(kChannels, kUnbounded);
    const std::size_t empty_bytes = store.bytes();
    const auto add_chunk = [&] {
        for (std::uint64_t i = 0; i < kChunk; ++i) {
            for (std::size_t channel = 130; channel < kChannels; ++channel) {
                const double value = number(random);
                row[channel] = channel < 150 ? std::round(1000.0 * value) : value;
            }
            store.add(1e-3 * static_cast<double>(store.end()), row);
        }
    };
    EXPECT_EQ(empty_bytes, kChunk * (kChannels + 1) * sizeof(double));
    add_chunk();
    add_chunk();
    const double bytes_per_row = static_cast<double>(store.bytes() - empty_bytes) / (2.0 * kChunk);
    constexpr double kRows = 300e3;
    EXPECT_LT(bytes_per_row * kRows, 130e6);
    // The numbers alone need 8 bytes each for the time and 40 channels, 4 for 20 channels.
    EXPECT_GT(bytes_per_row, 41.0 * 8.0 + 20.0 * 4.0);
}

TEST(ChannelStoreDeathTest, StopsAtAMisuse) {
    ChannelStore store(2, kUnbounded);
    const std::vector<double> row{1.0, 2.0};
    store.add(5.0, row);
    store.add(5.0, row);
    EXPECT_DEATH(store.add(std::nextafter(5.0, 0.0), row), "time_s >= last_time_s\\(\\)");
    EXPECT_DEATH(store.add(kNone, row), "time_s >= last_time_s\\(\\)");
    EXPECT_DEATH(store.add(5.0, std::span(row).first(1)), "row.size\\(\\) == channels_");
    EXPECT_DEATH(static_cast<void>(store.time_s(2)), "holds\\(row\\)");
    EXPECT_DEATH(static_cast<void>(store.value(2, 0)), "channel < channels_");
    EXPECT_DEATH(static_cast<void>(store.extremes(0, 0, 3)), "holds\\(from, to\\)");
    EXPECT_DEATH(static_cast<void>(store.row_at(kNone)), "isnan");
    store.clear();
    std::vector<double> copied;
    EXPECT_DEATH(store.copy(0, 1, 2, copied), "holds\\(from, to\\)");
}

} // namespace
} // namespace springdrive::record

#include "engine/record/channel_store.h"

#include "base/assertions.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace springdrive::record {

// Not anonymous, as members of ChannelStore::Chunk have these types.
namespace channel_store_parts {

constexpr std::size_t kRowsPerBlock = 64;
constexpr std::size_t kBlocksPerChunk = ChannelStore::kRowsPerChunk / kRowsPerBlock;
static_assert(ChannelStore::kRowsPerChunk % kRowsPerBlock == 0);

/// The channels that a chunk reorders at a time: as many as share a cache line of a row.
constexpr std::size_t kChannelsPerTile = 8;

// A double beyond the range of float converts to infinity and does not come back, so that it is
// recognised as not being a float.
static_assert(std::numeric_limits<float>::is_iec559);

using ChunkOfDoubles = std::array<double, ChannelStore::kRowsPerChunk>;

/// While there is no number, the minimum is above the maximum.
struct RunningExtremes {
    double minimum = std::numeric_limits<double>::infinity();
    double maximum = -std::numeric_limits<double>::infinity();

    /// Comparisons with NaN are false, so that it changes nothing.
    void add(double least, double greatest) {
        minimum = least < minimum ? least : minimum;
        maximum = greatest > maximum ? greatest : maximum;
    }
    void add(double value) { add(value, value); }
};

bool is_constant(const ChunkOfDoubles &values) {
    const auto first = std::bit_cast<std::uint64_t>(values.front());
    return std::ranges::all_of(
        values, [first](double value) { return std::bit_cast<std::uint64_t>(value) == first; });
}

/// Whether a conversion to float and back preserves every bit.
bool are_floats(const ChunkOfDoubles &values) {
    return std::ranges::all_of(values, [](double value) {
        return std::bit_cast<std::uint64_t>(static_cast<double>(static_cast<float>(value))) ==
               std::bit_cast<std::uint64_t>(value);
    });
}

/// The values of a channel that varies within its chunk.
template <typename Number> struct ChunkColumn {
    std::array<Number, ChannelStore::kRowsPerChunk> values;
    std::array<Number, kBlocksPerChunk> minima;
    std::array<Number, kBlocksPerChunk> maxima;

    static std::unique_ptr<const ChunkColumn> of(const ChunkOfDoubles &from) {
        auto column = std::make_unique_for_overwrite<ChunkColumn>();
        for (std::size_t block = 0; block < kBlocksPerChunk; ++block) {
            RunningExtremes extremes;
            const std::size_t first = block * kRowsPerBlock;
            for (std::size_t row = first; row < first + kRowsPerBlock; ++row) {
                column->values[row] = static_cast<Number>(from[row]);
                extremes.add(from[row]);
            }
            column->minima[block] = static_cast<Number>(extremes.minimum);
            column->maxima[block] = static_cast<Number>(extremes.maximum);
        }
        return column;
    }

    void add_extremes(std::size_t first, std::size_t last, RunningExtremes &extremes) const {
        const std::size_t first_block = (first + kRowsPerBlock - 1) / kRowsPerBlock;
        const std::size_t last_block = last / kRowsPerBlock;
        if (first_block >= last_block) {
            add_rows(first, last, extremes);
            return;
        }
        add_rows(first, first_block * kRowsPerBlock, extremes);
        for (std::size_t block = first_block; block < last_block; ++block) {
            extremes.add(minima[block], maxima[block]);
        }
        add_rows(last_block * kRowsPerBlock, last, extremes);
    }

private:
    void add_rows(std::size_t first, std::size_t last, RunningExtremes &extremes) const {
        for (std::size_t row = first; row < last; ++row) {
            extremes.add(values[row]);
        }
    }
};

} // namespace channel_store_parts

using namespace channel_store_parts;

/// Complete, therefore immutable.
struct ChannelStore::Chunk {
    /// Without a column, the channel is constant and `minimum` is its value, which may be NaN.
    struct Channel {
        double minimum;
        double maximum;
        std::unique_ptr<const ChunkColumn<float>> floats;
        std::unique_ptr<const ChunkColumn<double>> doubles;

        explicit Channel(const ChunkOfDoubles &values);
        [[nodiscard]] std::size_t bytes() const;
        [[nodiscard]] double value(std::size_t row) const;
        void add_extremes(std::size_t first, std::size_t last, RunningExtremes &extremes) const;
        void append(std::size_t first, std::size_t last, std::vector<double> &out) const;
    };

    ChunkOfDoubles times_s{};
    std::vector<Channel> channels;
    std::size_t bytes = sizeof(Chunk);

    /// @param rows  the values of row 0, then those of row 1, ...
    Chunk(std::span<const double> times, std::span<const double> rows, std::size_t channel_count);
};

ChannelStore::Chunk::Channel::Channel(const ChunkOfDoubles &values)
    : minimum(values.front()), maximum(values.front()) {
    if (is_constant(values)) {
        return;
    }
    RunningExtremes extremes;
    if (are_floats(values)) {
        floats = ChunkColumn<float>::of(values);
        floats->add_extremes(0, kRowsPerChunk, extremes);
    } else {
        doubles = ChunkColumn<double>::of(values);
        doubles->add_extremes(0, kRowsPerChunk, extremes);
    }
    minimum = extremes.minimum;
    maximum = extremes.maximum;
}

std::size_t ChannelStore::Chunk::Channel::bytes() const {
    return sizeof(Channel) + (floats ? sizeof *floats : 0) + (doubles ? sizeof *doubles : 0);
}

double ChannelStore::Chunk::Channel::value(std::size_t row) const {
    if (floats) {
        return floats->values[row];
    }
    return doubles ? doubles->values[row] : minimum;
}

void ChannelStore::Chunk::Channel::add_extremes(std::size_t first, std::size_t last,
                                                RunningExtremes &extremes) const {
    const bool is_whole = first == 0 && last == kRowsPerChunk;
    if (floats && !is_whole) {
        floats->add_extremes(first, last, extremes);
    } else if (doubles && !is_whole) {
        doubles->add_extremes(first, last, extremes);
    } else {
        extremes.add(minimum, maximum);
    }
}

void ChannelStore::Chunk::Channel::append(std::size_t first, std::size_t last,
                                          std::vector<double> &out) const {
    if (floats) {
        out.insert(out.end(), &floats->values[first], &floats->values[first] + (last - first));
    } else if (doubles) {
        out.insert(out.end(), &doubles->values[first], &doubles->values[first] + (last - first));
    } else {
        out.insert(out.end(), last - first, minimum);
    }
}

ChannelStore::Chunk::Chunk(std::span<const double> times, std::span<const double> rows,
                           std::size_t channel_count) {
    std::ranges::copy(times, times_s.begin());
    channels.reserve(channel_count);
    std::array<ChunkOfDoubles, kChannelsPerTile> tile{};
    for (std::size_t first = 0; first < channel_count; first += kChannelsPerTile) {
        const std::size_t width = std::min(kChannelsPerTile, channel_count - first);
        for (std::size_t row = 0; row < kRowsPerChunk; ++row) {
            for (std::size_t i = 0; i < width; ++i) {
                tile[i][row] = rows[row * channel_count + first + i];
            }
        }
        for (std::size_t i = 0; i < width; ++i) {
            channels.emplace_back(tile[i]);
            bytes += channels.back().bytes();
        }
    }
}

ChannelStore::ChannelStore(std::size_t channels, std::size_t max_bytes)
    : channels_(channels), max_bytes_(max_bytes) {}

void ChannelStore::add(double time_s, std::span<const double> row) {
    SPRINGDRIVE_ASSERT(row.size() == channels_);
    SPRINGDRIVE_ASSERT(time_s >= last_time_s());
    // The memory of the last open chunk is reused, but a copy has only as much as it holds.
    open_times_s_.reserve(kRowsPerChunk);
    open_rows_.reserve(kRowsPerChunk * channels_);
    open_times_s_.push_back(time_s);
    open_rows_.insert(open_rows_.end(), row.begin(), row.end());
    if (open_times_s_.size() == kRowsPerChunk) {
        complete_chunk();
    }
}

void ChannelStore::complete_chunk() {
    chunks_.push_back(std::make_shared<const Chunk>(open_times_s_, open_rows_, channels_));
    chunk_bytes_ += chunks_.back()->bytes;
    open_times_s_.clear();
    open_rows_.clear();
    while (bytes() > max_bytes_ && chunks_.size() > 1) {
        chunk_bytes_ -= chunks_.front()->bytes;
        chunks_.pop_front();
        begin_ += kRowsPerChunk;
    }
}

double ChannelStore::last_time_s() const {
    if (!open_times_s_.empty()) {
        return open_times_s_.back();
    }
    return chunks_.empty() ? -std::numeric_limits<double>::infinity()
                           : chunks_.back()->times_s.back();
}

template <typename OfChunk, typename OfOpen>
void ChannelStore::for_each_part(std::uint64_t from, std::uint64_t to, OfChunk &&of_chunk,
                                 OfOpen &&of_open) const {
    std::uint64_t row = from;
    while (row < to && row < open_begin()) {
        const std::size_t first = (row - begin_) % kRowsPerChunk;
        const std::size_t last = std::min<std::uint64_t>(kRowsPerChunk, first + (to - row));
        of_chunk(*chunks_[(row - begin_) / kRowsPerChunk], first, last);
        row += last - first;
    }
    if (row < to) {
        of_open(row - open_begin(), to - open_begin());
    }
}

double ChannelStore::time_s(std::uint64_t row) const {
    SPRINGDRIVE_ASSERT(holds(row));
    if (row >= open_begin()) {
        return open_times_s_[row - open_begin()];
    }
    return chunks_[(row - begin_) / kRowsPerChunk]->times_s[(row - begin_) % kRowsPerChunk];
}

double ChannelStore::value(std::size_t channel, std::uint64_t row) const {
    SPRINGDRIVE_ASSERT(channel < channels_ && holds(row));
    if (row >= open_begin()) {
        return open_rows_[(row - open_begin()) * channels_ + channel];
    }
    const Chunk &chunk = *chunks_[(row - begin_) / kRowsPerChunk];
    return chunk.channels[channel].value((row - begin_) % kRowsPerChunk);
}

std::uint64_t ChannelStore::row_at(double time_s) const {
    SPRINGDRIVE_ASSERT(!std::isnan(time_s));
    const auto chunk = std::ranges::lower_bound(
        chunks_, time_s, {}, [](const auto &complete) { return complete->times_s.back(); });
    const bool is_open = chunk == chunks_.end();
    const std::span<const double> times_s(is_open ? std::span<const double>(open_times_s_)
                                                  : (*chunk)->times_s);
    const auto chunks_before = static_cast<std::uint64_t>(chunk - chunks_.begin());
    const auto rows_before =
        static_cast<std::uint64_t>(std::ranges::lower_bound(times_s, time_s) - times_s.begin());
    return begin_ + chunks_before * kRowsPerChunk + rows_before;
}

std::optional<std::uint64_t> ChannelStore::row_shown_at(double time_s) const {
    const std::uint64_t row = row_at(time_s);
    if (row == end() || (row == begin_ && this->time_s(row) > time_s)) {
        return std::nullopt;
    }
    return this->time_s(row) > time_s ? row - 1 : row;
}

ChannelStore::Extremes ChannelStore::extremes(std::size_t channel, std::uint64_t from,
                                              std::uint64_t to) const {
    SPRINGDRIVE_ASSERT(channel < channels_ && holds(from, to));
    RunningExtremes extremes;
    for_each_part(
        from, to,
        [&](const Chunk &chunk, std::size_t first, std::size_t last) {
            chunk.channels[channel].add_extremes(first, last, extremes);
        },
        [&](std::size_t first, std::size_t last) {
            for (std::size_t row = first; row < last; ++row) {
                extremes.add(open_rows_[row * channels_ + channel]);
            }
        });
    if (extremes.minimum > extremes.maximum) {
        return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
    }
    return {extremes.minimum, extremes.maximum};
}

void ChannelStore::copy(std::size_t channel, std::uint64_t from, std::uint64_t to,
                        std::vector<double> &out) const {
    SPRINGDRIVE_ASSERT(channel < channels_ && holds(from, to));
    out.clear();
    out.reserve(to - from);
    for_each_part(
        from, to,
        [&](const Chunk &chunk, std::size_t first, std::size_t last) {
            chunk.channels[channel].append(first, last, out);
        },
        [&](std::size_t first, std::size_t last) {
            for (std::size_t row = first; row < last; ++row) {
                out.push_back(open_rows_[row * channels_ + channel]);
            }
        });
}

std::size_t ChannelStore::bytes() const {
    return chunk_bytes_ + kRowsPerChunk * (1 + channels_) * sizeof(double);
}

void ChannelStore::clear() {
    begin_ = end();
    chunks_.clear();
    chunk_bytes_ = 0;
    open_times_s_.clear();
    open_rows_.clear();
}

} // namespace springdrive::record

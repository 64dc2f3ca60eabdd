// The recent past of all telemetry channels in memory, for plots.
//
//            begin                                                             end
//              │ chunk        │ chunk        │ ...          │ open chunk        │
//   dropped ◄──┤ 1024 rows    │ 1024 rows    │              │ up to 1023 rows   ├──◄ add
//              │ by channel   │ by channel   │              │ row by row        │
//
// Most channels are constant, or small integers, for most of the time: in a complete chunk, a
// channel takes one number if it is constant, 4 bytes per row if floats hold it exactly, else 8.
// Every value comes back with all its bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace springdrive::record {

/// Values of many channels over time. When memory reaches a bound, the oldest rows are dropped.
///
/// A copy is a snapshot, for example for a paused plot: it shares the complete chunks, which never
/// change, and can be read by another thread while rows are added to the original. What it shares
/// stays in memory for as long as it lives, even if the original has dropped it.
class ChannelStore {
public:
    static constexpr std::size_t kRowsPerChunk = 1024;

    struct Extremes {
        double minimum;
        double maximum;

        /// Without any number, both are NaN.
        [[nodiscard]] bool is_empty() const { return !(minimum <= maximum); }
    };

    /// @param max_bytes  bound on `bytes()`. The open chunk and the newest complete one are always
    ///                   kept, even if they need more: up to 17 KiB per channel, time being one
    ChannelStore(std::size_t channels, std::size_t max_bytes);

    /// Allocates only when it completes a chunk, and when it is the first on a store or on a copy.
    /// @param time_s  must not decrease, except after `clear`
    /// @param row     one value per channel, NaN where there is none
    void add(double time_s, std::span<const double> row);

    /// Rows are numbered from the first one ever added; those from begin() to end() − 1 are kept.
    [[nodiscard]] std::uint64_t begin() const { return begin_; }
    [[nodiscard]] std::uint64_t end() const { return open_begin() + open_times_s_.size(); }
    [[nodiscard]] bool is_empty() const { return begin() == end(); }
    [[nodiscard]] std::size_t channels() const { return channels_; }

    // Rows and channels passed to these functions must exist; ranges [from, to) can be empty.

    [[nodiscard]] double time_s(std::uint64_t row) const;
    [[nodiscard]] double value(std::size_t channel, std::uint64_t row) const;

    /// The first kept row at or after that time; end() if there is none.
    [[nodiscard]] std::uint64_t row_at(double time_s) const;
    /// The row whose values are shown at a time: the first one at that time, or else the last one
    /// before it. None before the oldest kept row and after the newest.
    [[nodiscard]] std::optional<std::uint64_t> row_shown_at(double time_s) const;

    /// Ignores NaN. Apart from up to 126 rows at its ends and the open chunk, a range is read in
    /// blocks of 64 rows or whole chunks.
    [[nodiscard]] Extremes extremes(std::size_t channel, std::uint64_t from,
                                    std::uint64_t to) const;

    /// Replaces the contents of `out`, whose memory is reused.
    void copy(std::size_t channel, std::uint64_t from, std::uint64_t to,
              std::vector<double> &out) const;

    /// In use, including what copies share, without the allocator's overhead. The open chunk counts
    /// as if it were full.
    [[nodiscard]] std::size_t bytes() const;

    /// Drops all rows. The numbering continues.
    void clear();

private:
    struct Chunk;

    [[nodiscard]] std::uint64_t open_begin() const {
        return begin_ + chunks_.size() * kRowsPerChunk;
    }
    [[nodiscard]] bool holds(std::uint64_t row) const { return begin_ <= row && row < end(); }
    [[nodiscard]] bool holds(std::uint64_t from, std::uint64_t to) const {
        return begin_ <= from && from <= to && to <= end();
    }
    [[nodiscard]] double last_time_s() const; ///< −∞ if there is no row
    void complete_chunk();

    /// Calls of_chunk(chunk, first, last) for each part of [from, to) in a complete chunk, then
    /// of_open(first, last) for the part in the open one. Parts are [first, last) within the chunk.
    template <typename OfChunk, typename OfOpen>
    void for_each_part(std::uint64_t from, std::uint64_t to, OfChunk &&of_chunk,
                       OfOpen &&of_open) const;

    std::size_t channels_;
    std::size_t max_bytes_;
    std::uint64_t begin_ = 0;
    std::deque<std::shared_ptr<const Chunk>> chunks_;
    std::size_t chunk_bytes_ = 0; ///< of all complete chunks
    std::vector<double> open_times_s_;
    std::vector<double> open_rows_; ///< row by row
};

} // namespace springdrive::record

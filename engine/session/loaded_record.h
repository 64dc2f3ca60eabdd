// A record in memory: all channels of its rows, or of as many as fit from a given time on.
//
//   file ──► RecordReader ──► ServoSample ──► RecordRows ──► ChannelStore
#pragma once

#include "base/background.h"
#include "device/core/device_description.h"
#include "engine/record/channel_store.h"
#include "engine/record/record_header.h"
#include "engine/session/telemetry_channels.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::session {

/// The times of a first and a last row, by the servo's clock.
struct RowTimes {
    double first_s = 0.0;
    double last_s = 0.0;
};

/// Of a simulated device, which can be changed while it runs.
struct DelayChange {
    std::uint64_t from_tick = 0;
    double delay_periods = 0.0;
};

struct RecordedScene {
    std::string file;
    std::string sha256;
};

struct LoadedRecord {
    std::filesystem::path file;
    record::RecordHeader header;
    device::DeviceDescription device;
    record::ChannelStore store; ///< of all `channels()`; time_s increases strictly from row to row
    RowTimes all;               ///< of the file
    RowTimes loaded;            ///< of the store, which has at least one row
    std::string ending;         ///< how the file ends, and what was left out of it

    std::vector<DelayChange> delays{};               ///< noted ones, in the file's order
    std::map<std::uint32_t, RecordedScene> scenes{}; ///< noted ones, by scene_id

    /// d, which may change within a record.
    [[nodiscard]] double delay_periods_at(std::uint64_t tick) const;
    /// The scene of a tick: a noted one, or that of the header.
    [[nodiscard]] RecordedScene scene_of(const servo::ServoSample &sample) const;

    /// Whether the file has rows before or after those loaded.
    [[nodiscard]] bool is_partial() const {
        return all.first_s < loaded.first_s || loaded.last_s < all.last_s;
    }
    /// The row shown at a time: the last one until then; the first one before all rows. NaN: the
    /// first.
    [[nodiscard]] std::uint64_t row_shown_at(double time_s) const;
};

/// Reads a record. Any thread; takes seconds for a long record.
/// @param from_s     rows before that time are left out
/// @param max_bytes  of the store, which exceeds it by at most one chunk
/// @throw InputError naming the file, if it cannot be read, is not a record of this version, or has
///        no rows from `from_s` on
/// @throw NotWanted soon after it was cancelled
[[nodiscard]] LoadedRecord load_record(const std::filesystem::path &file, double from_s,
                                       std::size_t max_bytes, BackgroundTalk &talk);

/// Whether a sample can be a row of a store, which keeps whole numbers as doubles and is ordered by
/// time: false for a time that is not finite, and for a tick or measurement number of 2⁵³ or more.
[[nodiscard]] bool can_be_a_row(const servo::ServoSample &sample);

/// Makes rows of consecutive samples of a record, whose servo rate may change.
class RecordRows {
public:
    RecordRows(const device::PhantomGeometry &geometry, const record::RecordHeader &header);

    /// @param sample  later than the previous one, see also `can_be_a_row`
    void add(const servo::ServoSample &sample) { store_.add(sample.time_s, row_of(sample)); }
    /// Without a row for it: the next rows are as if it had one.
    void pass_over(const servo::ServoSample &sample) { static_cast<void>(row_of(sample)); }

    [[nodiscard]] const record::ChannelStore &store() const { return store_; }
    [[nodiscard]] record::ChannelStore take() && { return std::move(store_); }

private:
    [[nodiscard]] std::span<const double> row_of(const servo::ServoSample &sample);
    void follow_rate(const servo::ServoSample &sample);

    ChannelRow row_;
    record::ChannelStore store_{channels().size(), std::numeric_limits<std::size_t>::max()};
    std::optional<std::uint64_t> last_tick_; ///< of the previous sample
    double last_s_ = 0.0;                    ///< its time
};

} // namespace springdrive::session

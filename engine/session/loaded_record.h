// A record in memory: all channels of its rows, or of as many as fit from a given time on.
//
//   file ──► RecordReader ──► ServoSample ──► TelemetryHistory ──► ChannelStore
#pragma once

#include "base/background.h"
#include "device/core/device_description.h"
#include "engine/record/channel_store.h"
#include "engine/record/record_header.h"
#include "engine/session/telemetry_history.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
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
/// @throw Cancelled soon after it was cancelled
[[nodiscard]] LoadedRecord load_record(const std::filesystem::path &file, double from_s,
                                       std::size_t max_bytes, BackgroundTalk &talk);

/// For the rows of a record, none yet, and without a bound.
[[nodiscard]] TelemetryHistory history_for(const device::PhantomGeometry &geometry,
                                           const record::RecordHeader &header);

} // namespace springdrive::session

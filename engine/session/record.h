// A record in memory: rows of one device, of a file or of the session itself.
//
//   file  ──► load_record ───┐
//   servo ──► Session::past ─┴─► Record ──► playback, plots, what_if
//                                   └─────► write_record ──► file
#pragma once

#include "base/background.h"
#include "device/core/device_description.h"
#include "device/simulated/simulation_options.h"
#include "engine/record/channel_store.h"
#include "engine/record/record_format.h"
#include "engine/session/telemetry_history.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::session {

/// The times of a first and a last row, by the servo's clock.
struct RowTimes {
    double first_s = 0.0;
    double last_s = 0.0;
};

/// Rows of a store.
struct RowRange {
    std::uint64_t from = 0;
    std::uint64_t to = 0; ///< exclusive
};

/// Of a simulated device, which can be changed while it runs.
struct DelayChange {
    std::uint64_t from_tick = 0;
    double delay_periods = 0.0;
};

/// A device on which the session ran.
struct RunDevice {
    std::string name;
    std::string file;       ///< as it was typed
    std::string toml;       ///< the file's complete text
    std::uint64_t seed = 0; ///< see SimulationOptions
    simulated::PlantEffects effects;
    bool observes_resistance = true;
};

struct RunScene {
    std::string file;   ///< empty: none
    std::string sha256; ///< of the file, lower-case hex
    std::uint64_t triangles = 0;
};

/// An event of a record.
struct RecordNote {
    std::uint64_t before_row = 0; ///< of the store
    std::string json;
    /// Of a record that begins after it; null: the same as before.
    std::shared_ptr<const record::RecordHeader> header{};
};

struct Record {
    record::RecordHeader header;      ///< as at the first row
    device::DeviceDescription device; ///< of the header's text
    record::ChannelStore store{0, 0}; ///< a snapshot of all `channels()`
    RowRange rows{};                  ///< those of the record
    std::vector<RecordNote> notes{};  ///< in the order of their rows

    // Of a session:
    double start_s = 0.0; ///< the store's time at which the record's time is 0
    RunDevice ran_on{};

    // Of a file:
    std::filesystem::path file{};
    RowTimes all{};       ///< of all its rows; time_s increases strictly from row to row
    std::string ending{}; ///< how it ends, and what was left out of it

    /// Of the rows in memory. @pre there is one
    [[nodiscard]] RowTimes times() const {
        return {store.time_s(rows.from), store.time_s(rows.to - 1)};
    }
    /// Whether the file has rows before or after those in memory.
    [[nodiscard]] bool is_partial() const {
        return all.first_s < times().first_s || times().last_s < all.last_s;
    }

    /// Drops the rows before that one, with their notes: the header becomes that of the first row.
    void drop_before(std::uint64_t row);

    /// Calls take(sample) for each row and take_note(json) for each note, in their order.
    template <typename Take>
    void for_each(Take &&take, const std::function<void(std::string_view)> &take_note) const {
        auto note = notes.begin();
        for (std::uint64_t row = rows.from; row < rows.to; ++row) {
            for (; note != notes.end() && note->before_row <= row; ++note) {
                take_note(note->json);
            }
            take(sample_at(store, row));
        }
        for (; note != notes.end(); ++note) {
            take_note(note->json);
        }
    }
};

/// d, which may change within a record: that of the header, then the noted ones in their order.
[[nodiscard]] std::vector<DelayChange> delays_of(const Record &record);
/// @param delays  of the tick's record
[[nodiscard]] double delay_periods_at(std::uint64_t tick, const std::vector<DelayChange> &delays);

/// The noted scenes, by scene_id; all others are that of the header.
[[nodiscard]] std::map<std::uint32_t, RunScene> noted_scenes(const Record &record);

/// Reads a record. Any thread; takes seconds for a long record.
/// @param from_s     rows before that time are left out
/// @param max_bytes  of the store, which exceeds it by at most one chunk; the same of the notes
/// @throw InputError naming the file, if it cannot be read, is not a record of this version, or has
///        no rows from `from_s` on
/// @throw Cancelled soon after it was cancelled
[[nodiscard]] Record load_record(const std::filesystem::path &file, double from_s,
                                 std::size_t max_bytes, BackgroundTalk &talk);

/// Writes a record, whose tuning and global α at the start are those of the first row; without
/// rows, it has only the notes. Takes seconds: call it on a background thread. The snapshot's
/// memory stays in use for as long.
/// @throw InputError if the file exists or cannot be written, Cancelled if it was cancelled; no
///        file is left behind, and an existing one is as it was.
void write_record(const std::filesystem::path &file, const Record &record, BackgroundTalk &talk);

/// For the rows of a record, none yet, and without a bound.
[[nodiscard]] TelemetryHistory history_for(const device::PhantomGeometry &geometry,
                                           const record::RecordHeader &header);

} // namespace springdrive::session

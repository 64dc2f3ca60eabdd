// What happened in a session, with times; and how a session is kept in a run folder: what is still
// in memory, all that follows, and what the person wrote and saw.
//
//   keep ──► RunFolder ──► past.rec, ... (in the background), record.rec, ... (from now on)
//        └─► devices, tunings, log, notes, a picture: again with every keep, and at the end
#pragma once

#include "base/background.h"
#include "engine/servo/safety_status.h"
#include "engine/session/run_folder.h"
#include "engine/session/session.h"
#include "engine/session/tuning_history.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

/// What happened, with times: trips and resets, changes of the tuning, scenes, devices, rates,
/// records.
class EventLog {
public:
    static constexpr std::size_t kMaxEvents = 10'000; ///< beyond, the oldest are forgotten

    enum class Kind : std::uint8_t { note, change, trip };

    struct Event {
        double time_s = 0.0; ///< as in plots
        Kind kind = Kind::note;
        std::string what;
    };

    /// Once per frame. Trips are found in every tick, also those that were reset within a frame.
    void update(const session::Session &session);

    /// Oldest first.
    [[nodiscard]] const std::deque<Event> &events() const { return events_; }

private:
    void add(double time_s, Kind kind, std::string what);
    void watch_safety(const session::Session &session);
    void watch_tuning(const session::TuningHistory &tuning);
    void watch_plant(const session::Session &session, double now_s);
    void watch_rest(const session::Session &session, double now_s);

    std::deque<Event> events_;
    std::uint64_t next_row_ = 0;
    servo::SafetyState state_ = servo::SafetyState::waiting; ///< in the last row
    std::size_t journal_ = 1; ///< entries taken; the first one is the start
    std::uint32_t scene_id_ = 0;
    double rate_hz_ = 0.0;
    std::string device_;
    struct Plant {
        double delay_periods = 0.0;
        simulated::PlantEffects effects;
        double hand_stiffness_N_per_m = 0.0;
    };
    std::optional<Plant> plant_; ///< of a simulated device
    bool follows_path_ = false;
    std::size_t parts_ = 0; ///< of records
    bool recording_ = false;
    std::size_t warnings_ = 0;
};

/// Keeps a session in a run folder.
class SessionKeeper {
public:
    /// @param parent  folder in which those of runs are made; it is made for the first
    explicit SessionKeeper(std::filesystem::path parent);

    /// Makes the folder, or brings it up to date: ticks that are in no record yet are written, as
    /// far as they are in memory, and the session is recorded from now on. What failed before is
    /// tried again.
    void keep(session::Session &session, const EventLog &log);

    /// Once a frame: follows the session's devices and records.
    void update(const session::Session &session);

    /// Once the session has stopped, brings the folder up to date: waits until all is written.
    /// Notes that were written but never kept are kept then.
    void finish(session::Session &session, const EventLog &log);

    /// Empty until something was kept.
    [[nodiscard]] std::filesystem::path folder() const {
        return folder_ ? folder_->path() : std::filesystem::path();
    }
    /// The size of the records that the next keep makes of what is in memory, without their
    /// headers.
    [[nodiscard]] std::uint64_t bytes_to_write(const session::Session &session) const;
    [[nodiscard]] bool is_writing() const { return writing_.is_busy(); }
    /// Whether the last keep succeeded, and nothing was lost since.
    [[nodiscard]] bool is_kept() const { return folder_.has_value() && error_.empty(); }
    /// Why something could not be kept; else empty.
    [[nodiscard]] const std::string &error() const { return error_; }

    /// The picture of the window that is to be written once the frame is complete: once for every
    /// `keep`. Call `note_picture` when that was done, or `fail` if it could not be.
    [[nodiscard]] std::optional<std::filesystem::path> take_picture();
    /// @throw InputError if the folder cannot be brought up to date
    void note_picture(const std::filesystem::path &file, const session::Session &session,
                      const EventLog &log);
    void fail(const std::string &why) { error_ = why; }

    std::string notes; ///< the person's

private:
    /// A record that is in the folder, or listed in it.
    struct Kept {
        std::filesystem::path file;
        session::RunDevice device;
        double start_s = 0.0;       ///< see RunRecord
        std::uint64_t from_row = 0; ///< of the history, for their order
    };

    void begin_folder(session::Session &session);
    void record_from_now_on(session::Session &session);
    void write_uncovered(const session::Session &session);
    void take_written();
    void note_recording(const session::Session &session);
    void note_end_of_recording();
    void wait_for_writing();
    void save(const session::Session &session, const EventLog &log);
    [[nodiscard]] std::filesystem::path name_of_new(const std::string &stem) const;
    [[nodiscard]] session::RunFacts facts(const session::Session &session,
                                          const EventLog &log) const;

    std::filesystem::path parent_;
    std::chrono::sys_seconds started_;
    std::optional<session::RunFolder> folder_;
    std::vector<Kept> records_;
    std::vector<Kept> being_written_;
    std::uint64_t covered_to_row_ = 0; ///< of the history: up to here, all is in records
    bool was_recording_ = false;
    std::vector<std::filesystem::path> pictures_;
    bool wants_picture_ = false;
    std::string error_;
    Background<bool> writing_; ///< last member, so that it is joined first
};

} // namespace springdrive::app

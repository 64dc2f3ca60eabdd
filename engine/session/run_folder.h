// The folder of a session that its user keeps: all that is needed to look at it another day.
//
//   springdrive-20240531-123456/
//     run.json             what ran, and the names of the records and screenshots
//     past.rec             the ticks that were in memory when it was kept
//     record.rec, ...      recorded from then on
//     device.toml          the device's file; device-2.toml after an exchange, ...
//     tuning.toml, slot_a.toml, slot_b.toml
//     tuning_history.csv   the journal of tunings
//     events.csv           the log
//     notes.txt            the user's own text
//     screenshot-1.png, ...
//
// Times are those of the session's plots, in seconds: they go on after an exchange of the device,
// while those in a record begin with its device. `RunRecord::start_s` is the difference.
#pragma once

#include "engine/session/record.h"
#include "engine/session/tuning_history.h"

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::session {

struct RunRecord {
    std::filesystem::path file; ///< a bare name is in the folder; as read, all others are absolute
    double start_s = 0.0;       ///< the session's time at which the record's time is 0
    std::size_t device = 0;     ///< number in `RunFacts::devices`
};

/// A line of the log.
struct RunEvent {
    double time_s = 0.0;
    std::string text;
};

/// The contents of the folder, apart from records and pictures.
struct RunFacts {
    std::string software; ///< version of the program
    std::chrono::sys_seconds started{};
    std::chrono::sys_seconds kept{};
    double until_s = 0.0; ///< of the last tick
    double servo_hz = 0.0;
    double delay_periods = 0.0;     ///< d
    std::vector<RunDevice> devices; ///< in the order of their use
    RunScene scene;
    TuningSlots slots{control::Tuning{}};
    std::vector<TuningEvent> journal; ///< see `TuningHistory::journal`
    std::vector<RunEvent> events;
    std::string notes;
    std::vector<RunRecord> records;                 ///< in the order of their ticks
    std::vector<std::filesystem::path> screenshots; ///< bare names
};

class RunFolder {
public:
    /// Makes a folder named by the local time, with `-2`, `-3`, ... if that name is taken.
    /// @throw InputError if it cannot be made or written to; nothing is left behind.
    [[nodiscard]] static RunFolder create(const std::filesystem::path &parent);

    [[nodiscard]] const std::filesystem::path &path() const { return path_; }

    /// Writes all files but records and pictures; each replaces its predecessor at once and as a
    /// whole, `run.json` last. May be called again and again. The folder can be moved afterwards:
    /// files in it are listed by their names alone, others by their absolute paths.
    /// @throw InputError if a file cannot be written; it is then as it was, as are those after it.
    void save(const RunFacts &facts) const;

    /// The name of the next picture: "screenshot-1.png" if there is none.
    [[nodiscard]] std::filesystem::path next_screenshot() const;

private:
    explicit RunFolder(std::filesystem::path path) : path_(std::move(path)) {}

    std::filesystem::path path_;
};

/// Reads what is needed to look at a run again: `until_s`, each device's toml, the scene's file and
/// hash, the records, and the notes, which may be missing; all else keeps its default, as the
/// records hold it for each tick. Records are not opened: they may be missing, too.
/// @throw InputError in one line naming the file and what is wrong with it.
[[nodiscard]] RunFacts read_run(const std::filesystem::path &folder);

} // namespace springdrive::session

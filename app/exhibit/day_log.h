// The log of a day at an exhibit, for its demonstrator: one line for each event, and a summary.
//
//   2026-11-25 10:03:21  visitor 7 begins
//   2026-11-25 10:03:58  stopped: tip speed 1.24 m/s, limit 1.20 m/s
#pragma once

#include "engine/session/session.h"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace springdrive::app::exhibit {

/// Counts and peaks of a run.
struct DayFigures {
    std::uint64_t visitors = 0;
    std::uint64_t scenes = 0; ///< shown to visitors
    std::uint64_t trips = 0;
    std::uint64_t trips_during_recovery = 0; ///< those before the motors ran again after another
    std::uint64_t recovered = 0;     ///< times that the motors ran again after one trip or several
    std::uint64_t losses = 0;        ///< times that the device was lost
    double longest_recovery_s = 0.0; ///< from the first trip until the motors ran again
    double peak_force_N = 0.0;       ///< at the tip, while the motors were driven
    double peak_voltage_V = 0.0;     ///< |e_W| of any motor, while they were driven
    double longest_frame_s = 0.0;
};

/// The figures in one line: "40 visitors, 112 scenes; 4 stops (1 while healing), 3 healed, the
/// longest after 11 s; …"
[[nodiscard]] std::string summary_of(const DayFigures &figures);

/// The default file of the log: `springdrive/kiosk/DATE.log` in the user's folder of state; empty
/// where that is not known.
[[nodiscard]] std::filesystem::path usual_day_log();

/// Appends lines to a file. Those that cannot be written, for example on a full disk, are counted,
/// and the next one that can be written says how many are missing; the run goes on.
class DayLog {
public:
    /// @param file  empty: nothing is written
    explicit DayLog(std::filesystem::path file) : file_(std::move(file)) {}

    /// Appends the event with its local time; line breaks in it become spaces.
    void record(std::string_view event,
                std::chrono::system_clock::time_point when = std::chrono::system_clock::now());

    /// Why lines are missing: once, after the first that could not be written; otherwise empty.
    [[nodiscard]] std::string take_error();

private:
    [[nodiscard]] bool append(const std::string &text) const;

    std::filesystem::path file_;
    std::uint64_t missing_ = 0; ///< lines since the last that was written
    bool has_failed_ = false;
    std::string error_;
};

/// Watches the servo's telemetry for what the log reports: peaks, stops, a lost device.
class DayWatch {
public:
    /// Evaluates every tick since the last call; called once a frame.
    /// @return the events, each in one line
    std::vector<std::string> update(const session::Session &session, DayFigures &figures);

private:
    void watch_safety(const servo::SafetyStatus &safety, double time_s, DayFigures &figures,
                      std::vector<std::string> &events);

    std::uint64_t next_row_ = 0; ///< the first row of the telemetry that is not evaluated yet
    servo::SafetyState state_ = servo::SafetyState::waiting;
    std::uint32_t held_stop_ = 0; ///< number of the last requested stop
    bool is_stopped_ = false;     ///< tripped, and not run since
    double stopped_s_ = 0.0;      ///< time of the first trip since the motors ran
    bool is_lost_ = false;
};

} // namespace springdrive::app::exhibit

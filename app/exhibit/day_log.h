// The log of a day at an exhibit, for its demonstrator: one line an event, and a summary.
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
#include <vector>

namespace springdrive::app::exhibit {

/// What is summed up at the end of a run.
struct DayFigures {
    std::uint64_t visitors = 0;
    std::uint64_t scenes = 0; ///< shown to visitors
    std::uint64_t trips = 0;
    std::uint64_t trips_while_recovery = 0; ///< of these: the motors had not run since another
    std::uint64_t recovered = 0; ///< times that the motors ran again after one trip or several
    std::uint64_t losses = 0;    ///< of the device
    double longest_recovery_s = 0.0;
    double peak_force_N = 0.0;   ///< while the motors were driven
    double peak_voltage_V = 0.0; ///< of e_W, of any motor
    double longest_frame_s = 0.0;
};

/// "40 visitors, 112 scenes; 4 stops (1 while healing), 3 healed, the longest after 11 s; …"
[[nodiscard]] std::string summary_of(const DayFigures &figures);

/// `springdrive/kiosk/DATE.log` in the user's folder of state; empty where that is not known.
[[nodiscard]] std::filesystem::path usual_day_log();

/// Appends to its file. What cannot be written, for example on a full disk, is counted and never
/// ends the run; the next line that can be written says how many are missing.
class DayLog {
public:
    /// @param file  empty: nothing is written
    explicit DayLog(std::filesystem::path file) : file_(std::move(file)) {}

    /// @param event  in one line
    void note(std::string_view event,
              std::chrono::system_clock::time_point when = std::chrono::system_clock::now());

    /// Why a line is missing, once; else empty.
    [[nodiscard]] std::string take_error();

private:
    [[nodiscard]] bool append(const std::string &text) const;

    std::filesystem::path file_;
    std::uint64_t missing_ = 0;
    bool has_failed_ = false;
    std::string error_;
};

/// Watches the servo's telemetry for what the log reports: peaks, stops, a lost device.
class DayWatch {
public:
    /// Once a frame: takes in every tick since the last one.
    /// @return what happened, each in one line
    std::vector<std::string> update(const session::Session &session, DayFigures &figures);

private:
    void watch_safety(const servo::SafetyStatus &safety, double time_s, DayFigures &figures,
                      std::vector<std::string> &events);

    std::uint64_t next_row_ = 0;
    servo::SafetyState state_ = servo::SafetyState::waiting;
    std::uint32_t held_stop_ = 0;
    bool is_stopped_ = false; ///< and did not run since
    double stopped_s_ = 0.0;
    bool is_lost_ = false;
};

} // namespace springdrive::app::exhibit

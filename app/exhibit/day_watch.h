// Watches the servo's telemetry for what the log of the day reports: peaks, stops, a lost device.
#pragma once

#include "app/exhibit/day_log.h"
#include "engine/session/session.h"

#include <cstdint>
#include <string>
#include <vector>

namespace springdrive::app::exhibit {

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

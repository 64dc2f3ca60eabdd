// What happened in a session, with times: trips and resets, changes of the tuning, scenes, devices,
// rates, records.
#pragma once

#include "engine/session/session.h"
#include "engine/session/tuning_history.h"

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

namespace springdrive::app {

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
    double state_ = 0.0;      ///< of the monitor, in the last row
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

} // namespace springdrive::app

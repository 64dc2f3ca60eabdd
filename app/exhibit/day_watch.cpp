#include "app/exhibit/day_watch.h"

#include "engine/session/telemetry_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace springdrive::app::exhibit {

namespace {

using servo::SafetyState;

void raise(double &peak, double value) {
    if (std::isfinite(value)) {
        peak = std::max(peak, value);
    }
}

} // namespace

void DayWatch::watch_safety(const servo::SafetyStatus &safety, double time_s, DayFigures &figures,
                            std::vector<std::string> &events) {
    const SafetyState now = safety.state;
    const SafetyState before = std::exchange(state_, now);
    const bool is_requested = safety.held_stop > std::exchange(held_stop_, safety.held_stop);
    if (now == before) {
        if (is_requested) {
            events.emplace_back("stopped by hand while it was stopped");
        }
        return;
    }
    if (now == SafetyState::tripped) {
        ++figures.trips;
        events.push_back("stopped: " + servo::description(safety));
        if (std::exchange(is_stopped_, true)) {
            ++figures.trips_while_healing;
        } else {
            stopped_s_ = time_s;
        }
    } else if (now == SafetyState::running && is_stopped_) {
        is_stopped_ = false;
        ++figures.healed;
        const double healing_s = time_s - stopped_s_;
        raise(figures.longest_healing_s, healing_s);
        events.push_back(fmt::format("running again after {:.0f} s", healing_s));
    }
}

std::vector<std::string> DayWatch::update(const session::Session &session, DayFigures &figures) {
    std::vector<std::string> events;
    const record::ChannelStore &store = session.servo().history().store();
    for (std::uint64_t row = std::max(next_row_, store.begin()); row < store.end(); ++row) {
        const servo::ServoSample sample = session::sample_at(store, row);
        watch_safety(sample.safety, store.time_s(row), figures, events);
        if (servo::lets_pass(state_)) {
            raise(figures.peak_force_N, sample.tip_force_N.norm());
            for (const double e_W_V : sample.command.e_W_V) {
                raise(figures.peak_voltage_V, std::abs(e_W_V));
            }
        }
    }
    next_row_ = store.end();
    const bool is_lost = session.latest().health == device::DeviceHealth::lost;
    if (std::exchange(is_lost_, is_lost) != is_lost) {
        figures.losses += is_lost ? 1 : 0;
        events.emplace_back(is_lost ? "the device is lost" : "the device is there again");
    }
    return events;
}

} // namespace springdrive::app::exhibit

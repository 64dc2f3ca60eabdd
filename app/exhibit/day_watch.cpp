#include "app/exhibit/day_watch.h"

#include "engine/session/telemetry_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace springdrive::app::exhibit {

namespace {

using servo::SafetyState;

struct DayChannels {
    std::size_t state = session::channel_named("safety_state").value();
    std::size_t cause = session::channel_named("trip_cause").value();
    std::size_t measured = session::channel_named("trip_measured").value();
    std::size_t limit = session::channel_named("trip_limit").value();
    std::size_t held_stop = session::channel_named("held_stop").value();
    std::size_t force = session::channel_named("force_N").value();
    std::array<std::size_t, 3> voltage{session::channel_named("e_W1_V").value(),
                                       session::channel_named("e_W2_V").value(),
                                       session::channel_named("e_W3_V").value()};
};

const DayChannels &day_channels() {
    static const DayChannels all;
    return all;
}

void raise(double &peak, double value) {
    if (std::isfinite(value)) {
        peak = std::max(peak, value);
    }
}

std::string stop_text(const record::ChannelStore &store, std::uint64_t row) {
    const DayChannels &channel = day_channels();
    servo::SafetyStatus status;
    status.state = SafetyState::tripped;
    status.cause = static_cast<servo::TripCause>(static_cast<int>(store.value(channel.cause, row)));
    status.measured = store.value(channel.measured, row);
    status.limit = store.value(channel.limit, row);
    return "stopped: " + servo::description(status);
}

} // namespace

void DayWatch::watch_safety(const record::ChannelStore &store, std::uint64_t row,
                            DayFigures &figures, std::vector<std::string> &events) {
    const auto now =
        static_cast<SafetyState>(static_cast<int>(store.value(day_channels().state, row)));
    const SafetyState before = std::exchange(state_, now);
    const double held_stop = store.value(day_channels().held_stop, row);
    const bool is_requested = held_stop > std::exchange(held_stop_, held_stop);
    if (now == before) {
        if (is_requested) {
            events.emplace_back("stopped by hand while it was stopped");
        }
        return;
    }
    if (now == SafetyState::tripped) {
        ++figures.trips;
        events.push_back(stop_text(store, row));
        if (std::exchange(is_stopped_, true)) {
            ++figures.trips_while_healing;
        } else {
            stopped_s_ = store.time_s(row);
        }
    } else if (now == SafetyState::running && is_stopped_) {
        is_stopped_ = false;
        ++figures.healed;
        const double healing_s = store.time_s(row) - stopped_s_;
        raise(figures.longest_healing_s, healing_s);
        events.push_back(fmt::format("running again after {:.0f} s", healing_s));
    }
}

std::vector<std::string> DayWatch::update(const session::Session &session, DayFigures &figures) {
    std::vector<std::string> events;
    const record::ChannelStore &store = session.servo().history().store();
    for (std::uint64_t row = std::max(next_row_, store.begin()); row < store.end(); ++row) {
        watch_safety(store, row, figures, events);
        if (servo::lets_pass(state_)) {
            raise(figures.peak_force_N, store.value(day_channels().force, row));
            for (const std::size_t voltage : day_channels().voltage) {
                raise(figures.peak_voltage_V, std::abs(store.value(voltage, row)));
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

#include "app/panels/event_log.h"

#include "base/print.h"
#include "engine/servo/safety_status.h"
#include "engine/session/telemetry_history.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace springdrive::app {

namespace {

servo::SafetyState state_at(const record::ChannelStore &store, std::uint64_t row) {
    static const std::size_t kState = session::channel_named("safety_state").value();
    return static_cast<servo::SafetyState>(static_cast<int>(store.value(kState, row)));
}

} // namespace

void EventLog::add(double time_s, Kind kind, std::string what) {
    events_.push_back({time_s, kind, std::move(what)});
    if (events_.size() > kMaxEvents) {
        events_.pop_front();
    }
}

void EventLog::watch_safety(const session::Session &session) {
    const record::ChannelStore &store = session.servo().history().store();
    for (std::uint64_t row = std::max(next_row_, store.begin()); row < store.end(); ++row) {
        const servo::SafetyState now = state_at(store, row);
        const auto before = static_cast<servo::SafetyState>(static_cast<int>(state_));
        state_ = static_cast<double>(now);
        if (now == before) {
            continue;
        }
        const double time_s = store.time_s(row);
        if (now == servo::SafetyState::tripped) {
            add(time_s, Kind::trip,
                "stopped: " + servo::description(session::sample_at(store, row).safety));
        } else if (before == servo::SafetyState::tripped) {
            add(time_s, Kind::note, "reset");
        } else if (now == servo::SafetyState::running) {
            add(time_s, Kind::note, "motors running");
        } else if (now == servo::SafetyState::releasing) {
            add(time_s, Kind::note, "releasing the device");
        }
    }
    next_row_ = store.end();
}

void EventLog::watch_tuning(const session::TuningHistory &tuning) {
    for (; journal_ < tuning.journal().size(); ++journal_) {
        const session::TuningEvent &event = tuning.journal()[journal_];
        add(event.time_s, Kind::change, event.what);
    }
}

/// Of a simulated device.
void EventLog::watch_plant(const session::Session &session, double now_s) {
    if (!session.device().has_world()) {
        plant_.reset();
        return;
    }
    const simulated::SimulationOptions &now = session.simulation();
    if (plant_ && plant_->delay_periods != now.delay_periods) {
        add(now_s, Kind::note, fmt::format("delay of {:g} periods", now.delay_periods));
    }
    for (const simulated::PlantEffect &effect : simulated::kPlantEffects) {
        if (plant_ && plant_->effects.*effect.on != now.effects.*effect.on) {
            add(now_s, Kind::note,
                fmt::format("{} {}", effect.name, now.effects.*effect.on ? "on" : "off"));
        }
    }
    if (plant_ && plant_->hand_stiffness_N_per_m != now.hand.stiffness_N_per_m) {
        add(now_s, Kind::note, fmt::format("hand of {:.0f} N/m", now.hand.stiffness_N_per_m));
    }
    plant_ = Plant{now.delay_periods, now.effects, now.hand.stiffness_N_per_m};
    const bool follows = session.hand().follows_path();
    if (std::exchange(follows_path_, follows) != follows) {
        add(now_s, Kind::note, follows ? "the hand follows a path" : "the hand's path is over");
    }
}

void EventLog::watch_rest(const session::Session &session, double now_s) {
    const std::uint32_t scene_id = session.scenes().id();
    if (std::exchange(scene_id_, scene_id) != scene_id) {
        add(now_s, Kind::note, "scene " + session.scenes().now().scene.file.filename().string());
    }
    const std::string &device = session.description().name;
    if (std::exchange(device_, device) != device) {
        add(now_s, Kind::note, "device " + device);
    }
    const double rate_hz = session.servo().rate_hz();
    if (std::exchange(rate_hz_, rate_hz) != rate_hz) {
        add(now_s, Kind::note, fmt::format("servo at {:g} Hz", rate_hz));
    }
    const bool records = session.recording().is_running();
    const std::size_t parts = session.recording().parts().size();
    if (records && (!recording_ || parts != parts_)) {
        add(now_s, Kind::note, "recording to " + session.recording().file().string());
    } else if (!records && recording_) {
        add(now_s, Kind::note, "record ended");
    }
    recording_ = records;
    parts_ = parts;
    const auto &warnings = session.warnings().all();
    for (; warnings_ < warnings.size(); ++warnings_) {
        add(now_s, Kind::note, warnings[warnings_]);
    }
}

void EventLog::update(const session::Session &session) {
    const auto before = static_cast<std::ptrdiff_t>(events_.size());
    watch_safety(session);
    watch_tuning(session.tuning());
    const double now_s = session.plot_time_s();
    watch_plant(session, now_s);
    watch_rest(session, now_s);
    std::stable_sort(events_.begin() + std::min(before, std::ssize(events_)), events_.end(),
                     [](const Event &a, const Event &b) { return a.time_s < b.time_s; });
}

} // namespace springdrive::app

#include "app/exhibit/day_log.h"

#include "app/host/folders.h"
#include "base/new_file.h"
#include "base/text.h"
#include "engine/session/telemetry_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <system_error>
#include <utility>

namespace springdrive::app::exhibit {

namespace {

using servo::SafetyState;

/// "1 stop", "2 stops"
std::string counted(std::size_t count, std::string_view what) {
    return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

void raise(double &peak, double value) {
    if (std::isfinite(value)) {
        peak = std::max(peak, value);
    }
}

} // namespace

std::string summary_of(const DayFigures &figures) {
    std::string text =
        fmt::format("{}, {}; {}", counted(figures.visitors, "visitor"),
                    counted(figures.scenes, "scene"), counted(figures.trips, "stop"));
    if (figures.trips_during_recovery > 0) {
        text += fmt::format(" ({} while healing)", figures.trips_during_recovery);
    }
    text += fmt::format(", {} healed", figures.recovered);
    if (figures.recovered > 0) {
        text += fmt::format(", the longest after {:.0f} s", figures.longest_recovery_s);
    }
    return text + fmt::format("; the device was lost {}; peak force {:.2f} N, peak voltage "
                              "{:.2f} V; longest frame {:.0f} ms",
                              counted(figures.losses, "time"), figures.peak_force_N,
                              figures.peak_voltage_V, 1e3 * figures.longest_frame_s);
}

std::filesystem::path usual_day_log() {
    const std::filesystem::path state = user_folder("XDG_STATE_HOME", ".local/state");
    return state.empty() ? state : state / "kiosk" / (local_time("%F") + ".log");
}

void DayLog::record(std::string_view event, std::chrono::system_clock::time_point when) {
    if (file_.empty()) {
        return;
    }
    const std::string time = local_time("%F %T", when) + "  ";
    std::string text;
    if (missing_ > 0) {
        text = time + fmt::format("{} lines before this one could not be written\n", missing_);
    }
    text += time + one_line(event) + '\n';
    if (append(text)) {
        missing_ = 0;
        return;
    }
    ++missing_;
    if (!std::exchange(has_failed_, true)) {
        error_ = file_.string() + ": the log cannot be written; is the disk full, or the "
                                  "folder read-only? The exhibit goes on without it";
    }
}

/// Opened anew each time, so that a file that was moved away is begun again.
bool DayLog::append(const std::string &text) const {
    std::error_code ignored; // without its folder it cannot be opened
    if (file_.has_parent_path()) {
        std::filesystem::create_directories(file_.parent_path(), ignored);
    }
    std::ofstream out(file_, std::ios::app);
    out << text << std::flush;
    return static_cast<bool>(out);
}

std::string DayLog::take_error() { return std::exchange(error_, {}); }

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
            ++figures.trips_during_recovery;
        } else {
            stopped_s_ = time_s;
        }
    } else if (now == SafetyState::running && is_stopped_) {
        is_stopped_ = false;
        ++figures.recovered;
        const double recovery_s = time_s - stopped_s_;
        raise(figures.longest_recovery_s, recovery_s);
        events.push_back(fmt::format("running again after {:.0f} s", recovery_s));
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

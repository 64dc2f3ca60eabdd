#include "app/exhibit/day_log.h"

#include "app/host/user_folder.h"
#include "base/file_names.h"
#include "base/one_line.h"

#include <fmt/format.h>

#include <fstream>
#include <system_error>
#include <utility>

namespace springdrive::app::exhibit {

namespace {

/// "1 stop", "2 stops"
std::string counted(std::size_t count, std::string_view what) {
    return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

} // namespace

std::string summary_of(const DayFigures &figures) {
    std::string text =
        fmt::format("{}, {}; {}", counted(figures.visitors, "visitor"),
                    counted(figures.scenes, "scene"), counted(figures.trips, "stop"));
    if (figures.trips_while_healing > 0) {
        text += fmt::format(" ({} while healing)", figures.trips_while_healing);
    }
    text += fmt::format(", {} healed", figures.healed);
    if (figures.healed > 0) {
        text += fmt::format(", the longest after {:.0f} s", figures.longest_healing_s);
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

void DayLog::note(std::string_view event, std::chrono::system_clock::time_point when) {
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
    if (!std::exchange(has_complained_, true)) {
        complaint_ = file_.string() + ": the log cannot be written; is the disk full, or the "
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

std::string DayLog::take_complaint() { return std::exchange(complaint_, {}); }

} // namespace springdrive::app::exhibit

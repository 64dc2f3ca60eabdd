// The springdrive program while it runs, with a conversation over its streams; and its window with
// a person in front of it: what it shows is read from its own report.
#pragma once

#include "tests/support/person.h"
#include "tests/support/program.h"
#include "tests/support/virtual_display.h"

#include <nlohmann/json.hpp>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <sys/types.h>
#include <thread>
#include <vector>

namespace springdrive::testing {

/// It is killed with this object, and with the thread that created it. A thread of its own reads
/// its standard output at all times: the program never waits for the test to read.
class RunningProgram {
public:
    /// @param folder  where the program runs; empty for the folder of the test
    /// @throw std::runtime_error  the system has no process or no pipe for it
    RunningProgram(const VirtualDisplay &display, const std::vector<std::string> &arguments,
                   const std::filesystem::path &folder = {});
    ~RunningProgram();
    RunningProgram(const RunningProgram &) = delete;
    RunningProgram &operator=(const RunningProgram &) = delete;

    /// Writes `line` and a line end to its standard input.
    /// @throw std::runtime_error  the program has ended or closed it, or does not read for 60 s
    void send_line(const std::string &line);

    /// The next line of its standard output, without its end.
    /// @param timeout  60 s at most
    /// @return nothing if none came in time, or none will come as the program has ended
    [[nodiscard]] std::optional<std::string> read_line(std::chrono::duration<double> timeout);

    [[nodiscard]] bool is_running();
    [[nodiscard]] pid_t process() const { return process_; }

    /// What it wrote to standard error so far.
    [[nodiscard]] std::string error() const;

    /// Closes its standard input and waits for its end; kills it after 60 s, which is exit
    /// status −1. A second call returns the same.
    /// @param signal  sent first; 0 for none
    /// @return with the standard output that read_line has not returned
    Ending end(int signal);

private:
    void keep_reading(const std::stop_token &ended);
    void take(std::string_view text);
    void close_input();
    void reap(bool waits);
    void finish_reading();

    std::filesystem::path error_file_;
    pid_t process_ = -1;
    int input_ = -1;            ///< of the program; −1 once closed
    int output_ = -1;           ///< of the program
    std::optional<int> status_; ///< of waitpid, once it has ended
    std::chrono::duration<double> after_signal_{0.0};

    std::mutex mutex_; ///< of the following
    std::condition_variable arrived_;
    std::deque<std::string> lines_;
    std::string begun_line_;
    bool at_end_ = false;

    std::jthread reader_; ///< last, as it uses the others
};

/// A report of `demo --report`, see app/widgets/widgets.h.
class Report {
public:
    explicit Report(nlohmann::json json) : json_(std::move(json)) {}

    /// The first item whose id is `id` or ends in "/" and `id`; null if there is none.
    [[nodiscard]] const nlohmann::json *find(const std::string &id) const;
    /// @throw std::runtime_error naming the id and the items there are
    [[nodiscard]] const nlohmann::json &item(const std::string &id) const;
    [[nodiscard]] bool shows(const std::string &text) const; ///< as part of any item's text
    [[nodiscard]] std::string texts() const;                 ///< of all items, for messages
    /// A telemetry column of the latest sample; NaN where it has none.
    [[nodiscard]] double column(const std::string &name) const;
    [[nodiscard]] const nlohmann::json &all() const { return json_; }

private:
    nlohmann::json json_;
};

struct WindowSize {
    int width = 1280;
    int height = 720;
    double scale = 1.0;
    /// Whether the program is told; otherwise it chooses itself, on a display of this size.
    bool is_typed = true;
};

/// By what the time of frames and servo goes on.
enum class Pace {
    looks, ///< each look and each action takes two frames, and there are no others; none is drawn
    clock, ///< the computer's, and all frames are drawn
};

/// In the names of tests with parameters.
inline void PrintTo(const WindowSize &size, std::ostream *out) {
    *out << size.width << " x " << size.height << " at scale " << size.scale;
}

class ShownWindow {
public:
    /// Starts `demo --report` with these arguments, and waits until its window is there.
    explicit ShownWindow(std::vector<std::string> arguments = {}, const WindowSize &size = {},
                         const std::filesystem::path &folder = {}, Pace pace = Pace::looks);

    /// What the window shows now, after all that the person did.
    [[nodiscard]] Report look();

    /// Looks until `holds`; the last report. Fails the test after `limit_s` of both the clock's and
    /// the frames' time, saying `what`.
    Report wait_until(const std::function<bool(const Report &)> &holds, const std::string &what,
                      double limit_s = 60.0);

    /// Of the frames' time; with Pace::clock of the computer's.
    void let_pass(double duration_s);

    /// Waits until the motors run.
    void wait_until_running();

    void click(const std::string &id, int button = 1);
    /// Clicks an item that drops down, then its entry.
    void choose(const std::string &id, const std::string &entry);
    /// Clicks into a field, replaces its text and presses Enter.
    void enter(const std::string &id, const std::string &text);
    /// The point at this share of an item's width and height.
    [[nodiscard]] Point point_in(const std::string &id, float x = 0.5F, float y = 0.5F);

    [[nodiscard]] Person &person() { return person_; }
    [[nodiscard]] RunningProgram &program() { return program_; }
    [[nodiscard]] const VirtualDisplay &display() const { return display_; }

private:
    std::optional<std::string> report(); ///< nothing once the program has ended

    Pace pace_;
    bool has_ended_ = false;
    VirtualDisplay display_;
    RunningProgram program_;
    Person person_;
};

/// A widget that a reader sees.
struct ShownBox {
    std::string id;
    std::string text;
    double left, top, right, bottom;
};

/// @param panel  only of this one; empty for all
[[nodiscard]] std::vector<ShownBox> shown_boxes(const Report &report, const std::string &panel);

[[nodiscard]] bool overlap(const ShownBox &a, const ShownBox &b);

/// Expects that nothing in that panel is clipped, beyond the window or over something else.
void expect_side_by_side(const Report &report, const std::string &panel, const std::string &where);

} // namespace springdrive::testing

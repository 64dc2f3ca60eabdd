#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <limits>
#include <poll.h>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

namespace springdrive::testing {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kMax{60};

/// What the child needs; prepared before the fork.
struct Start {
    std::vector<std::string> words; ///< program and arguments
    std::string display;
    std::filesystem::path folder;
    std::filesystem::path error_file;
    int input = -1;
    int output = -1;
    pid_t parent = -1;
};

/// In the child. Never returns.
[[noreturn]] void become_program(Start start) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != start.parent) {
        _exit(0); // the test ended before the line above
    }
    const int error = open(start.error_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    dup2(start.input, STDIN_FILENO);
    dup2(start.output, STDOUT_FILENO);
    dup2(error, STDERR_FILENO);
    if (!start.folder.empty() && chdir(start.folder.c_str()) != 0) {
        _exit(126);
    }
    // As in run_program.
    setenv("ASAN_OPTIONS", "detect_leaks=0", 1); // NOLINT(concurrency-mt-unsafe)
    setenv("DISPLAY", start.display.c_str(), 1); // NOLINT(concurrency-mt-unsafe)
    unsetenv("WAYLAND_DISPLAY");                 // NOLINT(concurrency-mt-unsafe)
    std::vector<char *> argv;
    argv.reserve(start.words.size() + 1);
    for (std::string &word : start.words) {
        argv.push_back(word.data());
    }
    argv.push_back(nullptr);
    execv(argv[0], argv.data());
    _exit(127);
}

/// Writes to a pipe whose other end may be closed: an error then, not the end of the test.
ssize_t write_without_signal(int stream, std::string_view text) {
    sigset_t broken_pipe;
    sigset_t before;
    sigemptyset(&broken_pipe);
    sigaddset(&broken_pipe, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &broken_pipe, &before);
    const ssize_t written = write(stream, text.data(), text.size());
    const int why = errno;
    if (written < 0 && why == EPIPE) {
        const timespec at_once{};
        sigtimedwait(&broken_pipe, nullptr, &at_once);
    }
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    errno = why;
    return written;
}

/// Each program of a test has its own.
std::filesystem::path fresh_error_file() {
    static std::atomic<int> count{0};
    return fresh_folder("program_" + std::to_string(++count)) / "error";
}

} // namespace

RunningProgram::RunningProgram(const VirtualDisplay &display,
                               const std::vector<std::string> &arguments,
                               const std::filesystem::path &folder)
    : error_file_(fresh_error_file()) {
    std::array<int, 2> to_program{};
    std::array<int, 2> from_program{};
    // Closed on exec: another program must not keep this one's streams open.
    if (pipe2(to_program.data(), O_CLOEXEC) != 0 || pipe2(from_program.data(), O_CLOEXEC) != 0) {
        throw std::runtime_error("no pipe for " SPRINGDRIVE_PROGRAM);
    }
    Start start;
    start.words = {SPRINGDRIVE_PROGRAM};
    start.words.insert(start.words.end(), arguments.begin(), arguments.end());
    start.display = display.name();
    start.folder = folder;
    start.error_file = error_file_;
    start.input = to_program[0];
    start.output = from_program[1];
    start.parent = getpid();
    process_ = fork();
    if (process_ == 0) {
        become_program(std::move(start));
    }
    close(to_program[0]);
    close(from_program[1]);
    input_ = to_program[1];
    output_ = from_program[0];
    if (process_ < 0) {
        close(input_);
        close(output_);
        throw std::runtime_error("no process for " SPRINGDRIVE_PROGRAM);
    }
    fcntl(input_, F_SETFL, O_NONBLOCK);
    reader_ = std::jthread([this](const std::stop_token &ended) { keep_reading(ended); });
}

RunningProgram::~RunningProgram() {
    if (!status_) {
        kill(process_, SIGKILL);
        reap(true);
    }
    close_input();
    finish_reading();
    close(output_);
}

void RunningProgram::send_line(const std::string &line) {
    const std::string text = line + '\n';
    std::string_view rest = text;
    const Clock::time_point deadline = Clock::now() + kMax;
    while (!rest.empty()) {
        const ssize_t written = input_ < 0 ? -1 : write_without_signal(input_, rest);
        if (written > 0) {
            rest.remove_prefix(static_cast<std::size_t>(written));
            continue;
        }
        if (input_ < 0 || (errno != EAGAIN && errno != EINTR)) {
            throw std::runtime_error("the program no longer reads its standard input: " + error());
        }
        if (Clock::now() > deadline) {
            throw std::runtime_error("the program does not read its standard input");
        }
        pollfd watched{input_, POLLOUT, 0};
        poll(&watched, 1, 100);
    }
}

std::optional<std::string> RunningProgram::read_line(std::chrono::duration<double> timeout) {
    std::unique_lock lock(mutex_);
    arrived_.wait_for(lock, std::min<std::chrono::duration<double>>(timeout, kMax),
                      [this] { return at_end_ || !lines_.empty(); });
    if (lines_.empty()) {
        return std::nullopt;
    }
    std::string line = std::move(lines_.front());
    lines_.pop_front();
    return line;
}

bool RunningProgram::is_running() {
    reap(false);
    return !status_;
}

std::string RunningProgram::error() const { return contents_of(error_file_); }

Ending RunningProgram::end(int signal) {
    const Clock::time_point start = Clock::now();
    const bool was_running = is_running();
    if (was_running && signal != 0) {
        kill(process_, signal);
    }
    close_input();
    while (is_running()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        if (Clock::now() - start > kMax) {
            kill(process_, SIGKILL);
            reap(true);
        }
    }
    if (was_running) {
        after_signal_ = Clock::now() - start;
    }
    finish_reading();
    Ending ending;
    ending.exit_status = WIFEXITED(*status_) ? WEXITSTATUS(*status_) : -1;
    for (const std::string &line : lines_) {
        ending.out += line + '\n';
    }
    ending.out += begun_line_;
    ending.error = error();
    ending.after_signal = after_signal_;
    return ending;
}

/// In the thread of the reader, until the end of the stream; once the program has ended, until all
/// that it wrote has been read, even if a process that it started holds the stream open.
void RunningProgram::keep_reading(const std::stop_token &ended) {
    std::vector<char> piece(1U << 16U);
    for (;;) {
        const bool is_last_look = ended.stop_requested();
        pollfd watched{output_, POLLIN, 0};
        const bool has_more = poll(&watched, 1, is_last_look ? 0 : 20) > 0;
        if (!has_more && !is_last_look) {
            continue;
        }
        const ssize_t size = has_more ? read(output_, piece.data(), piece.size()) : 0;
        if (size > 0) {
            take({piece.data(), static_cast<std::size_t>(size)});
        } else {
            break;
        }
    }
    const std::lock_guard lock(mutex_);
    at_end_ = true;
    arrived_.notify_all();
}

void RunningProgram::take(std::string_view text) {
    const std::lock_guard lock(mutex_);
    for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
        begun_line_ += text.substr(0, end);
        lines_.push_back(std::exchange(begun_line_, {}));
        text.remove_prefix(end + 1);
    }
    begun_line_ += text;
    arrived_.notify_all();
}

void RunningProgram::close_input() {
    if (input_ >= 0) {
        close(std::exchange(input_, -1));
    }
}

/// Notes how it ended, if it has.
void RunningProgram::reap(bool waits) {
    int status = 0;
    if (!status_ && waitpid(process_, &status, waits ? 0 : WNOHANG) == process_) {
        status_ = status;
    }
}

/// Once the program has ended.
void RunningProgram::finish_reading() {
    reader_.request_stop();
    if (reader_.joinable()) {
        reader_.join();
    }
}

namespace {

constexpr std::chrono::seconds kAnswer{60};

constexpr double kQuickly_s = 6.0;     ///< of the frames' time, in about a second
constexpr double kLook_s = 2.0 / 60.0; ///< of the frames' time, see ReportRequests

std::vector<std::string> with_window(std::vector<std::string> arguments, const WindowSize &size,
                                     Pace pace) {
    if (pace == Pace::looks) {
        arguments.insert(arguments.begin(), {"--lockstep", "--unseen"});
    }
    if (size.is_typed) {
        arguments.insert(arguments.begin(),
                         {"--width", std::to_string(size.width), "--height",
                          std::to_string(size.height), "--scale", std::to_string(size.scale)});
    }
    arguments.insert(arguments.begin(), {"demo", "--report"});
    return arguments;
}

} // namespace

const nlohmann::json *Report::find(const std::string &id) const {
    for (const nlohmann::json &item : json_.at("items")) {
        const std::string whole = item.at("id");
        if (whole == id || whole.ends_with("/" + id)) {
            return &item;
        }
    }
    return nullptr;
}

const nlohmann::json &Report::item(const std::string &id) const {
    if (const nlohmann::json *found = find(id)) {
        return *found;
    }
    std::string ids;
    for (const nlohmann::json &item : json_.at("items")) {
        ids += "\n  " + item.at("id").get<std::string>();
    }
    throw std::runtime_error("the window shows no \"" + id + "\"; it shows:" + ids);
}

bool Report::shows(const std::string &text) const {
    return texts().find(text) != std::string::npos;
}

std::string Report::texts() const {
    std::string all;
    for (const nlohmann::json &item : json_.at("items")) {
        all += item.at("text").get<std::string>() + '\n';
    }
    return all;
}

double Report::column(const std::string &name) const {
    const nlohmann::json &value = json_.at("sample").at(name);
    if (value.is_boolean()) {
        return value.get<bool>() ? 1.0 : 0.0;
    }
    return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

ShownWindow::ShownWindow(std::vector<std::string> arguments, const WindowSize &size,
                         const std::filesystem::path &folder, Pace pace)
    : pace_(pace), display_(size.width, size.height),
      program_(display_, with_window(std::move(arguments), size, pace), folder), person_(display_) {
    if (pace_ == Pace::looks) {
        person_.settle_by([this] { (void)report(); });
    }
    person_.wait_for_window(std::chrono::seconds(30), pace_ == Pace::clock);
}

std::optional<std::string> ShownWindow::report() {
    if (has_ended_) {
        return {};
    }
    program_.send_line("report");
    std::optional<std::string> line = program_.read_line(kAnswer);
    has_ended_ = !line;
    return line;
}

Report ShownWindow::look() {
    const std::optional<std::string> line = report();
    if (!line) {
        throw std::runtime_error("the window does not report: " + program_.error());
    }
    return Report(nlohmann::json::parse(*line));
}

Report ShownWindow::wait_until(const std::function<bool(const Report &)> &holds,
                               const std::string &what, double limit_s) {
    const auto start = std::chrono::steady_clock::now();
    for (double frames_s = 0.0;; frames_s += kLook_s) {
        Report report = look();
        if (holds(report)) {
            return report;
        }
        const bool is_late =
            std::chrono::steady_clock::now() - start > std::chrono::duration<double>(limit_s);
        if (is_late && (pace_ == Pace::clock || frames_s > limit_s)) {
            ADD_FAILURE() << "not within " << limit_s << " s: " << what << "; the window shows\n"
                          << report.texts();
            return report;
        }
        // What other threads do is waited for by the clock.
        if (pace_ == Pace::clock || frames_s > kQuickly_s) {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    }
}

void ShownWindow::let_pass(double duration_s) {
    if (pace_ == Pace::clock) {
        std::this_thread::sleep_for(std::chrono::duration<double>(duration_s));
        return;
    }
    for (double frames_s = 0.0; frames_s < duration_s; frames_s += kLook_s) {
        (void)report();
    }
}

void ShownWindow::wait_until_running() {
    wait_until([](const Report &report) { return report.find("Servo") && report.shows("running"); },
               "the motors run");
}

Point ShownWindow::point_in(const std::string &id, float x, float y) {
    const auto place = [&] {
        const Report report = look();
        const nlohmann::json &item = report.item(id);
        return Point{item.at("x").get<float>() + x * item.at("width").get<float>(),
                     item.at("y").get<float>() + y * item.at("height").get<float>()};
    };
    // A person does not press on what moves: a message that appears may shift what is below it.
    constexpr int kMaxFrames = 20;
    Point there = place();
    for (int frame = 0; frame < kMaxFrames; ++frame) {
        const Point before = std::exchange(there, place());
        if (there.x == before.x && there.y == before.y) {
            break;
        }
    }
    return there;
}

void ShownWindow::click(const std::string &id, int button) {
    const Point middle = point_in(id);
    person_.click(middle.x, middle.y, button);
}

void ShownWindow::choose(const std::string &id, const std::string &entry) {
    click(id);
    click(id + "/" + entry);
}

void ShownWindow::enter(const std::string &id, const std::string &text) {
    click(id);
    person_.clear_field();
    person_.type(text);
    person_.key("Return");
}

std::vector<ShownBox> shown_boxes(const Report &report, const std::string &panel) {
    static const std::set<std::string> kSurfaces{"panel", "tooltip"};
    std::vector<ShownBox> boxes;
    for (const auto &item : report.all().at("items")) {
        const bool is_in_panel =
            panel.empty() || item.at("id").get<std::string>().starts_with(panel + "/");
        if (is_in_panel && !kSurfaces.contains(item.at("kind")) && item.value("visible", true)) {
            boxes.push_back({item.at("id"), item.at("text"), item.at("x"), item.at("y"),
                             item.at("x").get<double>() + item.at("width").get<double>(),
                             item.at("y").get<double>() + item.at("height").get<double>()});
        }
    }
    return boxes;
}

bool overlap(const ShownBox &a, const ShownBox &b) {
    constexpr double kRounding = 1.0; // of places to pixels
    return std::min(a.right, b.right) - std::max(a.left, b.left) > kRounding &&
           std::min(a.bottom, b.bottom) - std::max(a.top, b.top) > kRounding;
}

void expect_side_by_side(const Report &report, const std::string &panel, const std::string &where) {
    for (const auto &item : report.all().at("items")) {
        EXPECT_FALSE(item.at("id").get<std::string>().starts_with(panel) &&
                     item.value("overflows", false))
            << where << ": " << item.dump();
    }
    const std::vector<ShownBox> boxes = shown_boxes(report, panel);
    EXPECT_FALSE(boxes.empty()) << panel;
    const double width = report.all().at("window").at("width");
    const double height = report.all().at("window").at("height");
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        EXPECT_LE(boxes[i].right, width + 1.0) << where << ": " << boxes[i].id;
        EXPECT_LE(boxes[i].bottom, height + 1.0) << where << ": " << boxes[i].id;
        for (std::size_t j = i + 1; j < boxes.size(); ++j) {
            EXPECT_FALSE(overlap(boxes[i], boxes[j]))
                << where << ": \"" << boxes[i].id << "\" (" << boxes[i].text << ") and \""
                << boxes[j].id << "\" (" << boxes[j].text << ")";
        }
    }
}

} // namespace springdrive::testing

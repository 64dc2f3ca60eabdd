#include "app/window/report_requests.h"

#include "app/widgets/widgets.h"

#include <array>
#include <iostream>
#include <poll.h>
#include <unistd.h>
#include <utility>

namespace springdrive::app {

namespace {

bool has_request(int wait_ms) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    return ::poll(&input, 1, wait_ms) > 0;
}

constexpr std::size_t kMaxLine = 1000;

} // namespace

bool ReportRequests::wait() {
    constexpr int kWait_ms = 100; // a signal to end may have come just before
    take_in(asked_ > 0 ? 0 : kWait_ms);
    return asked_ > 0;
}

void ReportRequests::begin_frame(bool has_input) {
    begun_ = std::chrono::steady_clock::now();
    if (are_read_) {
        take_in(0);
    }
    frames_ = asked_ > 0 && !has_input ? frames_ + 1 : 0;
    ui::report().begin(asked_ > 0 && frames_ >= kFrames);
}

double ReportRequests::frame_s() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count();
}

void ReportRequests::take_in(int wait_ms) {
    while (!has_ended_ && has_request(std::exchange(wait_ms, 0))) {
        std::array<char, 256> bytes{};
        const ssize_t count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
        has_ended_ = count <= 0; // closed: nobody asks any more
        read_.append(bytes.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
    }
    for (std::size_t end = read_.find('\n'); end != std::string::npos; end = read_.find('\n')) {
        const std::string line = read_.substr(0, end);
        read_.erase(0, end + 1);
        if (line == "report") {
            ++asked_;
            frames_ = 0;
        } else {
            std::cerr << "springdrive: --report: unknown request; only \"report\" is understood\n";
        }
    }
    if (read_.size() > kMaxLine) {
        read_.clear();
    }
}

void ReportRequests::end_frame(int width, int height, float scale,
                               const servo::ServoSample &latest) {
    ++frame_;
    durations_.add(frame_s());
    if (!ui::report().is_wanted()) {
        return;
    }
    const std::string line =
        json_line(ui::report(), facts_of(frame_, width, height, scale, durations_), latest);
    for (; asked_ > 0; --asked_) {
        std::cout << line << '\n';
    }
    std::cout << std::flush;
}

} // namespace springdrive::app

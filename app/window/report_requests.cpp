#include "app/window/report_requests.h"

#include "app/host/process.h"
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
    while (asked_ == 0 && !has_ended_ && !asked_to_end()) {
        take_in(kWait_ms);
    }
    return asked_ > 0 || !has_ended_;
}

void ReportRequests::begin_frame(const ReportedWindow &window) {
    begun_ = std::chrono::steady_clock::now();
    if (are_read_) {
        take_in(0);
    }
    frames_ = asked_ > 0 && !window.has_waiting_input ? frames_ + 1 : 0;
    ui::report().begin(asked_ > 0 && frames_ >= kFrames);
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

void ReportRequests::end_frame(const ReportedWindow &window, const servo::ServoSample &latest) {
    ++frame_;
    durations_.add(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count());
    if (!ui::report().is_requested()) {
        return;
    }
    const WindowFacts facts =
        facts_of(frame_, window.size.width, window.size.height, window.scale, durations_);
    const std::string line = json_line(ui::report(), facts, latest);
    for (; asked_ > 0; --asked_) {
        std::cout << line << '\n';
    }
    std::cout << std::flush;
}

} // namespace springdrive::app

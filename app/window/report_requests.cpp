#include "app/window/report_requests.h"

#include <array>
#include <iostream>
#include <poll.h>
#include <unistd.h>
#include <utility>

namespace springdrive::app {

namespace {

bool has_input() {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    return ::poll(&input, 1, 0) > 0;
}

constexpr std::size_t kLongestLine = 1000;

} // namespace

void ReportRequests::poll() {
    while (!has_ended_ && has_input()) {
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
    if (read_.size() > kLongestLine) {
        read_.clear();
    }
    if (asked_ > 0) {
        ++frames_;
    }
}

void ReportRequests::answer(const std::string &line) {
    for (; asked_ > 0; --asked_) {
        std::cout << line << '\n';
    }
    std::cout << std::flush;
}

} // namespace springdrive::app

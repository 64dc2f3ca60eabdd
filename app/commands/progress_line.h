// The progress of a long command.
#pragma once

#include <cmath>
#include <iostream>
#include <string_view>
#include <unistd.h>

namespace springdrive::app {

/// One line on standard error, rewritten in place; only on a terminal.
class ProgressLine {
public:
    ~ProgressLine() {
        if (watched_ && begun_) {
            std::cerr << "\r\x1b[K" << std::flush;
        }
    }
    ProgressLine() = default;
    ProgressLine(const ProgressLine &) = delete;
    ProgressLine &operator=(const ProgressLine &) = delete;

    void show(std::string_view what, double share) {
        const long percent = std::lround(100.0 * share);
        if (watched_ && (!begun_ || percent != percent_)) {
            begun_ = true;
            percent_ = percent;
            std::cerr << "\r\x1b[K" << what << ' ' << percent << " %" << std::flush;
        }
    }

private:
    bool watched_ = isatty(STDERR_FILENO) != 0;
    bool begun_ = false;
    long percent_ = 0;
};

} // namespace springdrive::app

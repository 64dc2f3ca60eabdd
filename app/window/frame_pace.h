// Limits frames to 60 per second by the clock, for displays without vertical synchronisation and
// for runs without a display.
#pragma once

#include <algorithm>
#include <chrono>
#include <thread>

namespace springdrive::app {

inline constexpr double kFrame_s = 1.0 / 60.0;

class FramePace {
    using Clock = std::chrono::steady_clock;

public:
    void wait() {
        next_ +=
            std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(kFrame_s));
        next_ = std::max(next_, Clock::now() - std::chrono::milliseconds(50));
        std::this_thread::sleep_until(next_);
    }

    [[nodiscard]] double elapsed_s() const {
        return std::chrono::duration<double>(Clock::now() - start_).count();
    }

private:
    Clock::time_point start_ = Clock::now();
    Clock::time_point next_ = start_;
};

} // namespace springdrive::app

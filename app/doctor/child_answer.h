// Work in a process of its own that may crash or never end.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <sys/types.h>

namespace springdrive::app::doctor {

/// Used while this process has no other thread: forks.
class ChildAnswer {
public:
    using Clock = std::chrono::steady_clock;

    /// Starts `work`, which sees neither standard input nor the terminal. It ends with this
    /// process.
    explicit ChildAnswer(const std::function<std::string()> &work);
    ~ChildAnswer(); ///< kills the child, without waiting for one that cannot be killed
    ChildAnswer(const ChildAnswer &) = delete;
    ChildAnswer &operator=(const ChildAnswer &) = delete;

    /// What `work` returned; none if it crashed, threw, or has not returned by then.
    [[nodiscard]] std::optional<std::string> by(Clock::time_point deadline);

private:
    pid_t child_ = -1;
    int pipe_ = -1;
};

} // namespace springdrive::app::doctor

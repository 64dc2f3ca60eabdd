// Destroys values whose destructors take long, e.g. gigabytes of data, on a background thread.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace springdrive {

/// Used from one thread. The destructor waits until all values are destroyed.
template <typename Value> class BackgroundRelease {
public:
    BackgroundRelease() = default;
    BackgroundRelease(const BackgroundRelease &) = delete;
    BackgroundRelease &operator=(const BackgroundRelease &) = delete;
    ~BackgroundRelease() {
        {
            const std::lock_guard lock(mutex_);
            is_ending_ = true;
        }
        wake_.notify_one();
    }

    /// Does not wait. The thread starts with the first value.
    void let_go(std::unique_ptr<Value> value) {
        {
            const std::lock_guard lock(mutex_);
            waiting_.push_back(std::move(value));
        }
        wake_.notify_one();
        if (!thread_.joinable()) {
            thread_ = std::jthread([this] { run(); });
        }
    }

private:
    void run() {
        for (;;) {
            std::vector<std::unique_ptr<Value>> values;
            {
                std::unique_lock lock(mutex_);
                wake_.wait(lock, [this] { return is_ending_ || !waiting_.empty(); });
                if (waiting_.empty()) {
                    return;
                }
                values.swap(waiting_);
            }
        }
    }

    std::mutex mutex_;
    std::condition_variable wake_;
    std::vector<std::unique_ptr<Value>> waiting_;
    bool is_ending_ = false;
    std::jthread thread_; ///< last member, so that it is joined first
};

} // namespace springdrive

// Background threads: work that takes longer than a frame, one job at a time, and the destruction
// of values whose destructors take long.
#pragma once

#include "base/cancellation.h"

#include <atomic>
#include <condition_variable>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace springdrive {

/// State shared between the background work and the frame loop.
struct BackgroundTalk {
    std::atomic<double> share{0.0};        ///< progress, 0 to 1
    std::atomic<bool> is_cancelled{false}; ///< the result is no longer needed
    std::atomic<bool> has_ended{false};    ///< the work, and its thread has released what it owned

    [[nodiscard]] bool is_needed() const { return !is_cancelled; }

    /// Called by the work to report its current stage and progress; ends work that was cancelled.
    /// @throw Cancelled if it was cancelled
    void report(const std::string &what, double so_far) {
        if (is_cancelled) {
            throw Cancelled();
        }
        share = so_far;
        const std::lock_guard lock(mutex_);
        what_ = what;
    }
    [[nodiscard]] std::string what() const {
        const std::lock_guard lock(mutex_);
        return what_;
    }

private:
    mutable std::mutex mutex_;
    std::string what_;
};

/// Runs one job at a time. Used from one thread. Starting and cancelling do not wait for work that
/// is no longer needed; the destructor does, so the work must poll `is_needed`, or call
/// `stop_if_given_up` deep in its call tree.
template <typename Result> class Background {
public:
    using Work = std::function<Result(BackgroundTalk &)>;

    Background() = default;
    Background(const Background &) = delete;
    Background &operator=(const Background &) = delete;
    ~Background() { give_up(); }

    [[nodiscard]] bool is_busy() const { return result_.valid(); }
    [[nodiscard]] double share() const { return talk_ ? talk_->share.load() : 0.0; }
    [[nodiscard]] std::string what() const { return talk_ ? talk_->what() : std::string(); }

    /// Starts `work`, and cancels what was running.
    /// @param work  must own all that it uses
    void start(Work work) {
        give_up();
        talk_ = std::make_shared<BackgroundTalk>();
        std::packaged_task<Result()> task([work = std::move(work), talk = talk_] {
            const StopScope by(&talk->is_cancelled);
            return work(*talk);
        });
        result_ = task.get_future();
        threads_.push_back({talk_, std::jthread([task = std::move(task), talk = talk_]() mutable {
                                task();
                                task = {}; // releases what it owned on this thread
                                talk->has_ended = true;
                            })});
    }

    void give_up() {
        ask_to_end();
        result_ = {};
        join_ended();
    }

    /// The work may then end early, by an exception; `take` still reports when it has ended.
    void ask_to_end() {
        if (talk_) {
            talk_->is_cancelled = true;
        }
    }

    /// The result, once, when its thread no longer shares it. Throws what the work threw.
    [[nodiscard]] std::optional<Result> take() {
        join_ended();
        if (!result_.valid() || !talk_->has_ended) {
            return std::nullopt;
        }
        return std::exchange(result_, {}).get();
    }

private:
    struct Thread {
        std::shared_ptr<const BackgroundTalk> talk;
        std::jthread thread; ///< joins on destruction
    };

    void join_ended() {
        std::erase_if(threads_, [](const Thread &thread) { return thread.talk->has_ended.load(); });
    }

    std::shared_ptr<BackgroundTalk> talk_;
    std::future<Result> result_;
    std::vector<Thread> threads_; ///< of current work and of cancelled work still running
};

/// Destroys values whose destructors take long, e.g. gigabytes of data, on a background thread.
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

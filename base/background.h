// Work that takes longer than a frame, on a thread of its own, one piece at a time.
#pragma once

#include "base/wanted.h"

#include <atomic>
#include <chrono>
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

/// What the work and the frame tell each other.
struct BackgroundTalk {
    std::atomic<double> share{0.0};       ///< how far the work is, 0 to 1
    std::atomic<bool> is_given_up{false}; ///< nobody waits for it any more

    [[nodiscard]] bool is_wanted() const { return !is_given_up; }

    /// For the work: what it is at, and how far. Ends it where nobody wants it.
    /// @throw NotWanted in that case
    void tell(const std::string &what, double so_far) {
        if (is_given_up) {
            throw NotWanted();
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

/// Used from one thread. Starting or giving up does not wait for work that is not wanted any more;
/// going away does, so work has to look again and again: at `is_wanted`, or far below its own code
/// by `stop_if_given_up`.
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

    /// Starts, and gives up what was going on.
    /// @param work  must own all that it uses
    void start(Work work) {
        give_up();
        talk_ = std::make_shared<BackgroundTalk>();
        std::packaged_task<Result()> task([work = std::move(work), talk = talk_] {
            const GivenUpBy by(&talk->is_given_up);
            return work(*talk);
        });
        result_ = task.get_future();
        const auto has_ended = std::make_shared<std::atomic<bool>>(false);
        threads_.push_back({has_ended, std::jthread([task = std::move(task), has_ended]() mutable {
                                task();
                                task = {}; // what it owned is let go of here
                                *has_ended = true;
                            })});
    }

    void give_up() {
        ask_to_end();
        result_ = {};
        join_ended();
    }

    /// The work may end early, by an exception; `take` still tells when it has ended.
    void ask_to_end() {
        if (talk_) {
            talk_->is_given_up = true;
        }
    }

    /// The result, once, when it is ready. Throws what the work threw.
    [[nodiscard]] std::optional<Result> take() {
        join_ended();
        if (!result_.valid() ||
            result_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
            return std::nullopt;
        }
        return std::exchange(result_, {}).get();
    }

private:
    struct Thread {
        std::shared_ptr<std::atomic<bool>> has_ended;
        std::jthread thread; ///< joins when it goes
    };

    void join_ended() {
        std::erase_if(threads_, [](const Thread &thread) { return thread.has_ended->load(); });
    }

    std::shared_ptr<BackgroundTalk> talk_;
    std::future<Result> result_;
    std::vector<Thread> threads_; ///< of the work, and of some that was given up before
};

} // namespace springdrive

// Work that takes longer than a frame, on a thread of its own, one piece at a time.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

namespace springdrive {

/// What the work and the frame tell each other.
struct BackgroundTalk {
    std::atomic<double> share{0.0};    ///< how far the work is, 0 to 1
    std::atomic<bool> is_wanted{true}; ///< false: nobody waits for it any more

    /// For the work: what it is at, and how far. Ends it where nobody wants it.
    /// @throw std::runtime_error in that case
    void tell(const std::string &what, double so_far) {
        if (!is_wanted) {
            throw std::runtime_error("given up");
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

/// Used from one thread. Going away does not wait: work that nobody wants ends when it looks.
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
        std::packaged_task<Result()> task(
            [work = std::move(work), talk = talk_] { return work(*talk); });
        result_ = task.get_future();
        std::thread(std::move(task)).detach();
    }

    void give_up() {
        ask_to_end();
        result_ = {};
    }

    /// The work may end early, by an exception; `take` still tells when it has ended.
    void ask_to_end() {
        if (talk_) {
            talk_->is_wanted = false;
        }
    }

    /// The result, once, when it is ready. Throws what the work threw.
    [[nodiscard]] std::optional<Result> take() {
        if (!result_.valid() ||
            result_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
            return std::nullopt;
        }
        return std::exchange(result_, {}).get();
    }

private:
    std::shared_ptr<BackgroundTalk> talk_;
    std::future<Result> result_;
};

} // namespace springdrive

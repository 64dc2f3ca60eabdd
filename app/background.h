// Work that takes longer than a frame, on a thread of its own, one piece at a time.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

namespace springdrive {

/// What the work and the frame tell each other.
struct BackgroundTalk {
    std::atomic<double> share{0.0};    ///< how far the work is, 0 to 1
    std::atomic<bool> is_wanted{true}; ///< false: nobody waits for it any more
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
        if (talk_) {
            talk_->is_wanted = false;
        }
        result_ = {};
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

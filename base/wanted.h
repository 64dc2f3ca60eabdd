// Long work that somebody may stop wanting half-way: a thread says once whose wish its work goes
// by, and loops far below look at it, so that none of what lies between has to pass it on.
#pragma once

#include <atomic>
#include <cstddef>
#include <stdexcept>

namespace springdrive {

/// The work under way is not wanted any more.
class NotWanted : public std::runtime_error {
public:
    NotWanted() : std::runtime_error("given up") {}
};

namespace wanted {

/// Of this thread's work; null where nobody can stop wanting it.
inline thread_local const std::atomic<bool> *is_given_up = nullptr;

} // namespace wanted

/// While it lives, this thread's work goes by that flag. `in_chunks` and `for_each_in_parallel`
/// hand it on to the threads that help.
class GivenUpBy {
public:
    /// @param is_given_up  must outlive it; null for none
    explicit GivenUpBy(const std::atomic<bool> *is_given_up) : before_(wanted::is_given_up) {
        wanted::is_given_up = is_given_up;
    }
    ~GivenUpBy() { wanted::is_given_up = before_; }
    GivenUpBy(const GivenUpBy &) = delete;
    GivenUpBy &operator=(const GivenUpBy &) = delete;

private:
    const std::atomic<bool> *before_;
};

/// Costs as much as looking at a flag.
/// @throw NotWanted where this thread's work was given up
inline void stop_if_given_up() {
    if (wanted::is_given_up != nullptr && wanted::is_given_up->load(std::memory_order_relaxed)) {
        throw NotWanted();
    }
}

/// The same for a quick loop, which it slows down by nothing to speak of.
/// @param step  of the loop, from any number on; only one in many looks
inline void stop_if_given_up(std::size_t step) {
    constexpr std::size_t kBetweenLooks = 16'384;
    if (step % kBetweenLooks == 0) {
        stop_if_given_up();
    }
}

} // namespace springdrive

// What a thread needs from the system to keep a deadline, and what the system said to it.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace springdrive::servo {

/// Below the kernel's own threads (99), above everything that a desktop runs.
inline constexpr int kServoPriority = 80;

/// Asks for the calling thread: SCHED_FIFO at kServoPriority, memory that is never paged out, and
/// to stay on the processor `cpu` if one is named; and touches its stack beforehand. Returns a
/// remark for each thing refused, with its remedy behind a semicolon; empty when all was granted.
/// Call once at a thread's start: allocates.
[[nodiscard]] std::vector<std::string> make_this_thread_real_time(std::optional<int> cpu);

/// Keeps the processors from idling so deeply that waking up takes long, as long as it lives.
class ShortIdle {
public:
    ShortIdle();
    ~ShortIdle();
    ShortIdle(const ShortIdle &) = delete;
    ShortIdle &operator=(const ShortIdle &) = delete;

    /// Why it cannot, with the remedy; empty where it can.
    [[nodiscard]] const std::string &remark() const { return remark_; }

private:
    int file_ = -1;
    std::string remark_;
};

/// For `--cpu`.
/// @throw InputError unless this process may run on processor `cpu`.
void check_cpu(int cpu);

/// Keeps the calling thread, and those that it starts from now on, off a processor that the servo
/// stays on: on many kernels what is in the midst of a write to disk is not interrupted. Does
/// nothing where there is no other.
void keep_off_cpu(int cpu) noexcept;

} // namespace springdrive::servo

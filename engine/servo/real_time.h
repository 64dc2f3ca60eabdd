// Requests from the operating system what a thread needs to keep deadlines, and reports refusals.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace springdrive::servo {

/// Below the kernel's threads (99), above everything that a desktop runs.
inline constexpr int kServoPriority = 80;

/// Requests that all memory of this process, present and future, stays in RAM: only where no limit
/// is set, as later allocations would fail at the limit. It does not apply to the superuser.
/// @return whether it is granted
[[nodiscard]] bool request_locked_memory();

/// Requests for the calling thread SCHED_FIFO at kServoPriority, locked memory and, if `cpu` is
/// given, affinity to that processor; also touches its stack in advance. Returns a warning for each
/// refusal, with a remedy after a semicolon; empty if all was granted. Call once at a thread's
/// start: allocates.
[[nodiscard]] std::vector<std::string> make_this_thread_real_time(std::optional<int> cpu);

/// While it exists, keeps the processors out of deep idle states, from which waking takes long.
class ShortIdle {
public:
    ShortIdle();
    ~ShortIdle();
    ShortIdle(const ShortIdle &) = delete;
    ShortIdle &operator=(const ShortIdle &) = delete;

    /// Why it could not, with the remedy; empty on success.
    [[nodiscard]] const std::string &warning() const { return warning_; }

private:
    int file_ = -1;
    std::string warning_;
};

/// Checks the option `--cpu`.
/// @throw InputError unless this process may run on processor `cpu`.
void check_cpu(int cpu);

/// Keeps the calling thread, and those that it starts from now on, off the servo's processor: many
/// kernels do not preempt a thread during a write to disk. Does nothing if there is no other
/// processor.
void keep_off_cpu(int cpu) noexcept;

} // namespace springdrive::servo

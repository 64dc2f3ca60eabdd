// Covers engine/record/ as a whole: a program that is killed while recording.
#include "engine/record/recorder.h"

#include "engine/record/record_file.h"
#include "tests/engine/record/samples.h"
#include "tests/support/cases.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <new>
#include <sys/mman.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace springdrive::record {
namespace {

constexpr double kServo_hz = 10'000.0;
constexpr std::uint64_t kMaxLost = 1000; // 0.1 s
constexpr std::uint64_t kNothing = ~std::uint64_t{0};

using Newest = std::atomic<std::uint64_t>;
static_assert(Newest::is_always_lock_free); // shared between processes

/// Shared memory that outlives a child process.
Newest &shared_tick() {
    void *const memory =
        mmap(nullptr, sizeof(Newest), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    return *new (memory) Newest(kNothing);
}

/// Runs ticks in real time until it is killed.
[[noreturn]] void record_for_ever(const std::filesystem::path &file, Newest &newest) {
    SampleRing<servo::ServoSample> ring(1U << 14U);
    Recorder recorder(ring);
    recorder.start(file, record_header(kServo_hz), Recorder::Mode::own_thread);
    servo::ServoSample sample;
    auto deadline = std::chrono::steady_clock::now();
    for (;;) {
        if (ring.push(sample)) {
            newest.store(sample.tick++);
        }
        deadline += std::chrono::microseconds(100);
        std::this_thread::sleep_until(deadline);
    }
}

/// Checks that ticks start at 0 without gaps; returns their number.
std::uint64_t contiguous_rows(const std::filesystem::path &file) {
    RecordReader reader(file);
    std::uint64_t rows = 0;
    reader.for_each([&](const servo::ServoSample &sample) { EXPECT_EQ(sample.tick, rows++); });
    EXPECT_EQ(reader.ending().missing_ticks, 0U);
    return rows;
}

TEST(RecordKill, LosesAtMostATenthOfASecond) {
    const auto folder = testing::fresh_folder("record_kill");
    std::mt19937_64 random(1);
    std::uniform_int_distribution<int> some_ms(50, 300);
    for (int i = 0; i < testing::cases(10, 100); ++i) {
        const auto file = folder / (std::to_string(i) + ".rec");
        Newest &newest = shared_tick();
        const pid_t child = fork();
        if (child == 0) {
            record_for_ever(file, newest);
        }
        while (newest == kNothing) { // until it has started, even on a busy machine
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(some_ms(random)));
        kill(child, SIGKILL);
        waitpid(child, nullptr, 0);
        const std::uint64_t pushed = newest + 1;
        const std::uint64_t kept = contiguous_rows(file);
        EXPECT_LE(pushed, kept + kMaxLost) << file;
        EXPECT_LE(kept, pushed + 1) << file; // killed between push and store
        munmap(&newest, sizeof newest);
        std::filesystem::remove(file);
    }
}

} // namespace
} // namespace springdrive::record

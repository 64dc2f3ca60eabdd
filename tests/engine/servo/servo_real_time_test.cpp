// Covers engine/servo/servo.cpp: its thread, once started, only computes, sleeps and reads the
// clock. Also covers that the watch (tests/support/real_time_watch.h) detects violations.
#include "base/assertions.h"
#include "device/core/forwarding_device.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/lab/rig/scenario/scenarios.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/servo/servo.h"
#include "tests/support/devices.h"
#include "tests/support/real_time_watch.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <linux/futex.h>
#include <pthread.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace springdrive::servo {
namespace {

using testing::watched;

constexpr int kNone = -1;
constexpr auto kTimeout = std::chrono::seconds(30);

/// Ends this child when the servo has done enough or was caught, after a final `check`.
template <typename IsEnough, typename Check>
[[noreturn]] void run_watched(Servo &servo, const contact::HapticSurface *surface,
                              IsEnough &&is_enough, Check &&check) {
    ServoInputs inputs;
    inputs.surface = surface;
    servo.publish(inputs);
    servo.feed_recorder(true);
    servo.start({{}, testing::watch_this_thread_for_good});
    const auto end = std::chrono::steady_clock::now() + kTimeout;
    bool enough = false;
    while (!enough && watched().system_call == kNone && std::chrono::steady_clock::now() < end) {
        servo.drain([&](const ServoSample &sample) { enough = enough || is_enough(sample); });
        servo.record_ring().drain([](const ServoSample & /*sample*/) {});
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    EXPECT_TRUE(watched().has_filter);
    check(enough);
    testing::end_this_child();
}

void expect_nothing_seen() {
    EXPECT_EQ(watched().allocations, 0);
    EXPECT_EQ(watched().locks, 0);
    EXPECT_EQ(watched().system_call, kNone);
}

class RealTimeServo : public ::testing::Test {
protected:
    void SetUp() override {
        if (!testing::can_filter_system_calls()) {
            GTEST_SKIP() << "this kernel does not support filtering system calls (seccomp)";
        }
    }
};

TEST_F(RealTimeServo, NeitherAllocatesNorLocksNorCallsWithAMillionTriangles) {
    const contact::HapticSurface surface(*rig::test_surface_named("sphere:1310720"));
    const bool holds = testing::holds_in_a_child([&] {
        const Vector3 upper_m = Vector3::Constant(rig::kTestSphereRadius_m);
        const rig::Scenario scenario = rig::scripted_touch_scenario(
            {testing::phantom_1_0(), {}}, rig::placed(surface, -upper_m, upper_m));
        simulated::SimulatedPhantom device(scenario.device, scenario.simulation, scenario.start_m);
        Servo servo(device, 1000.0);
        int touching = 0;
        run_watched(
            servo, &surface,
            [&](const ServoSample &sample) {
                touching += sample.contact.touching ? 1 : 0;
                return touching > 500;
            },
            [](bool enough) {
                EXPECT_TRUE(enough);
                expect_nothing_seen();
            });
    });
    EXPECT_TRUE(holds);
}

/// A device whose driver performs an action on the servo's thread in its twentieth tick.
class Driver final : public device::ForwardingDevice {
public:
    explicit Driver(std::function<void()> action)
        : device::ForwardingDevice(std::make_unique<simulated::SimulatedPhantom>(
              testing::phantom_1_0(), simulated::SimulationOptions{},
              testing::phantom_1_0().workspace.centre_m)),
          action_(std::move(action)) {}

    [[nodiscard]] device::Measurement read() noexcept override {
        if (++ticks_ == 20) {
            action_();
        }
        return device::ForwardingDevice::read();
    }

private:
    std::function<void()> action_;
    int ticks_ = 0;
};

struct DriverAction {
    const char *name;
    std::function<void()> act;
    long system_call = kNone; ///< that it makes
};

/// Runs a servo whose driver performs `action`, and checks what the watch has seen.
template <typename Check> bool holds_for(const DriverAction &action, Check &&check) {
    return testing::holds_in_a_child([&] {
        Driver driver(action.act);
        Servo servo(driver, 1000.0);
        run_watched(
            servo, nullptr, [](const ServoSample &sample) { return sample.tick > 40; },
            [&](bool enough) {
                EXPECT_TRUE(enough || watched().system_call != kNone);
                check();
            });
    });
}

TEST_F(RealTimeServo, TheWatchHasNoFalseAlarms) {
    const bool holds = holds_for({"nothing", [] {}}, [] { expect_nothing_seen(); });
    EXPECT_TRUE(holds);
}

TEST_F(RealTimeServo, NeitherAllocatesNorLocksNorCallsAfterAFailedAssertion) {
    const bool holds = testing::holds_in_a_child([] {
        Driver driver([] { SPRINGDRIVE_ASSERT(watched().locks < 0); });
        Servo servo(driver, 1000.0);
        run_watched(
            servo, nullptr,
            [](const ServoSample &sample) {
                return sample.tick > 40 && sample.safety.cause == TripCause::assertion;
            },
            [](bool enough) {
                EXPECT_TRUE(enough);
                expect_nothing_seen();
            });
    });
    EXPECT_TRUE(holds);
}

TEST_F(RealTimeServo, TheWatchDetectsAllocations) {
    static std::atomic<void *> kept = nullptr; // otherwise the compiler may omit the allocation
    static std::atomic<void *> none = nullptr;
    static auto *old = new std::vector<char>(100);
    const std::array actions{
        DriverAction{"malloc", [] { kept = std::malloc(1); }},                    // NOLINT
        DriverAction{"calloc", [] { kept = std::calloc(1, 1); }},                 // NOLINT
        DriverAction{"realloc", [] { kept = std::realloc(none, 1); }},            // NOLINT
        DriverAction{"aligned_alloc", [] { kept = std::aligned_alloc(64, 64); }}, // NOLINT
        DriverAction{"new", [] { kept = new char; }},                             // NOLINT
        DriverAction{"free", [] { std::free(none); }},                            // NOLINT
        DriverAction{"a vector that grows", [] { old->resize(1000); }},
        DriverAction{"a vector that goes", [] { delete old; }}, // NOLINT
    };
    for (const DriverAction &action : actions) {
        const bool seen = holds_for(action, [] { EXPECT_GT(watched().allocations, 0); });
        EXPECT_TRUE(seen) << action.name;
    }
}

TEST_F(RealTimeServo, TheWatchDetectsLocks) {
    static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
    static pthread_rwlock_t lock = PTHREAD_RWLOCK_INITIALIZER;
    static std::mutex standard;
    const std::array actions{
        DriverAction{"a mutex", [] { pthread_mutex_lock(&mutex); }},
        DriverAction{"a mutex tried", [] { static_cast<void>(pthread_mutex_trylock(&mutex)); }},
        DriverAction{"a lock to read", [] { pthread_rwlock_rdlock(&lock); }},
        DriverAction{"a lock to write", [] { pthread_rwlock_wrlock(&lock); }},
        DriverAction{"C++'s own", [] { const std::lock_guard guard(standard); }},
    };
    for (const DriverAction &action : actions) {
        const bool seen = holds_for(action, [] { EXPECT_EQ(watched().locks, 1); });
        EXPECT_TRUE(seen) << action.name;
    }
}

TEST_F(RealTimeServo, TheWatchDetectsSystemCalls) {
    static int word = 0;
    const std::array actions{
        DriverAction{"write", [] { static_cast<void>(write(STDOUT_FILENO, "!", 1) == 1); },
                     SYS_write},
        DriverAction{"wake", [] { syscall(SYS_futex, &word, FUTEX_WAKE, 1); }, SYS_futex},
        DriverAction{"yield", [] { sched_yield(); }, SYS_sched_yield},
        DriverAction{"open", [] { static_cast<void>(open("/dev/null", O_RDONLY)); }, SYS_openat},
        DriverAction{"control", [] { ioctl(0, FIONREAD, &word); }, SYS_ioctl},
        DriverAction{"map",
                     [] {
                         static_cast<void>(
                             mmap(nullptr, 1, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
                     },
                     SYS_mmap},
        DriverAction{"unmap", [] { munmap(nullptr, 1); }, SYS_munmap},
        DriverAction{"break", [] { syscall(SYS_brk, nullptr); }, SYS_brk},
        DriverAction{"advise", [] { madvise(nullptr, 1, MADV_NORMAL); }, SYS_madvise},
        DriverAction{"ask", [] { getppid(); }, SYS_getppid},
    };
    for (const DriverAction &action : actions) {
        const bool seen =
            holds_for(action, [&] { EXPECT_EQ(watched().system_call, action.system_call); });
        EXPECT_TRUE(seen) << action.name;
    }
}

} // namespace
} // namespace springdrive::servo

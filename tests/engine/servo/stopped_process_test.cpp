// Covers engine/servo/servo.cpp: the whole process is stopped for a while, e.g. by SIGSTOP, a
// debugger or a suspended computer, and continues.
#include "engine/servo/servo.h"

#include "device/simulated/simulated_phantom.h"
#include "tests/support/devices.h"
#include "tests/support/own_clock_device.h"

#include <gtest/gtest.h>

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <new>
#include <thread>

namespace springdrive::servo {
namespace {

constexpr std::uint64_t kEarlyTicks = 1500; // wait, ramp and run
constexpr std::uint64_t kLaterTicks = 300;
constexpr std::uint64_t kMissed = 1900;          // of the 2000 of the stop
constexpr std::chrono::milliseconds kStop{2000}; ///< longer than any limit of the device's

/// Results of a stopped process, in memory shared with the process that stops it.
struct Account {
    std::atomic<std::uint64_t> ticks{0};
    SafetyStatus last_safety;
    double max_e_W_after_V = 0.0; ///< since the first tick after the stop
    double longest_step_s = 0.0;  ///< of the device's time between two ticks
    std::uint64_t missed_deadlines = 0;
};

/// Runs a servo with heartbeats until it trips or has run for a while after the stop.
void run(device::HapticDevice &device, Account &account) {
    Servo servo(device, 1000.0);
    ServoInputs inputs;
    servo.start();
    std::uint64_t later = 0;
    const auto take = [&](const ServoSample &sample) {
        account.missed_deadlines += sample.missed_deadlines;
        account.longest_step_s = std::max(account.longest_step_s, sample.since_last_s);
        account.last_safety = sample.safety;
        if (account.missed_deadlines >= kMissed) {
            ++later;
            account.max_e_W_after_V =
                std::max(account.max_e_W_after_V, sample.command.e_W_V.cwiseAbs().maxCoeff());
        }
        account.ticks = sample.tick + 1;
    };
    while (later < kLaterTicks && account.last_safety.state != SafetyState::tripped) {
        ++inputs.heartbeat;
        servo.publish(inputs);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        servo.drain(take);
    }
    servo.stop();
}

/// The account of a process that is stopped for kStop once its servo runs.
class StoppedProcess {
public:
    explicit StoppedProcess(bool claims_to_be_hardware) {
        void *page = mmap(nullptr, sizeof(Account), PROT_READ | PROT_WRITE,
                          MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        account_ = new (page) Account;
        const pid_t child = fork();
        if (child == 0) {
            live(claims_to_be_hardware);
        }
        while (account_->ticks < kEarlyTicks && waitpid(child, &status_, WNOHANG) == 0) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        kill(child, SIGSTOP);
        waitpid(child, &status_, WUNTRACED);
        was_stopped_ = WIFSTOPPED(status_);
        std::this_thread::sleep_for(kStop);
        kill(child, SIGCONT);
        waitpid(child, &status_, 0);
    }
    ~StoppedProcess() { munmap(account_, sizeof(Account)); }
    StoppedProcess(const StoppedProcess &) = delete;
    StoppedProcess &operator=(const StoppedProcess &) = delete;

    [[nodiscard]] bool ended_well() const {
        return was_stopped_ && WIFEXITED(status_) && WEXITSTATUS(status_) == 0;
    }
    [[nodiscard]] const Account &account() const { return *account_; }

private:
    [[noreturn]] void live(bool claims_to_be_hardware) {
        device::DeviceDescription description = testing::phantom_1_0();
        // Deadlines that a busy computer misses before the stop are not what is tested.
        description.limits.late_s = 0.5 * std::chrono::duration<double>(kStop).count();
        description.limits.window_silence_s = 10.0;
        simulated::SimulatedPhantom phantom(description, {}, Vector3(0.0, 0.02, 0.0));
        testing::OwnClockDevice hardware(phantom, 1e-3);
        device::HapticDevice &simulated = phantom;
        run(claims_to_be_hardware ? hardware : simulated, *account_);
        _exit(0);
    }

    Account *account_;
    int status_ = 0;
    bool was_stopped_ = false;
};

TEST(StoppedProcess, ASimulatedDeviceContinuesUnchanged) {
    const StoppedProcess process(false);
    ASSERT_TRUE(process.ended_well());
    const Account &account = process.account();
    EXPECT_EQ(account.last_safety.state, SafetyState::running) << description(account.last_safety);
    EXPECT_DOUBLE_EQ(account.longest_step_s, 1e-3);
    EXPECT_GE(account.missed_deadlines, kMissed); // counted nevertheless
}

TEST(StoppedProcess, ADeviceWithItsOwnClockTripsOnDeadlinesAndIsNotDriven) {
    const StoppedProcess process(true);
    ASSERT_TRUE(process.ended_well());
    const Account &account = process.account();
    EXPECT_EQ(account.last_safety.state, SafetyState::tripped);
    EXPECT_EQ(account.last_safety.cause, TripCause::missed_deadlines);
    EXPECT_EQ(account.max_e_W_after_V, 0.0);
}

} // namespace
} // namespace springdrive::servo

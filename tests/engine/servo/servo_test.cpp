// Covers engine/servo/servo.cpp: the thread, its clock and its end; a process that is stopped for a
// while, e.g. by SIGSTOP, a debugger or a suspended computer; an assertion that fails in a tick.
#include "engine/servo/servo.h"

#include "base/assertions.h"
#include "base/input_error.h"
#include "device/core/haptic_device.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/record/telemetry_columns.h"
#include "tests/support/devices.h"
#include "tests/support/servo_devices.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace springdrive::servo {
namespace {

const Vector3 kStart_m(0.0, 0.02, 0.0);

/// A simulated device that stores the last command.
class RecordingDevice final : public device::ForwardingDevice {
public:
    RecordingDevice()
        : device::ForwardingDevice(std::make_unique<simulated::SimulatedPhantom>(
              testing::phantom_1_0(), simulated::SimulationOptions{}, kStart_m)) {}

    void write(const device::DeviceCommand &command) noexcept override {
        last_command = command;
        ++commands;
        device::ForwardingDevice::write(command);
    }

    device::DeviceCommand last_command;
    int commands = 0;
};

/// All columns of a sample, as bytes.
std::string bytes_of(const ServoSample &sample) {
    std::string bytes;
    record::for_each_column(sample,
                            [&bytes](std::string_view, std::string_view, const auto &value) {
                                bytes.append(reinterpret_cast<const char *>(&value), sizeof value);
                            });
    return bytes;
}

std::vector<std::string> rows_of(Servo &servo) {
    std::vector<std::string> rows;
    servo.drain([&rows](const ServoSample &sample) { rows.push_back(bytes_of(sample)); });
    return rows;
}

TEST(Servo, SendsTheSafeStateLastAlsoFromItsThread) {
    for (const bool on_its_thread : {false, true}) {
        RecordingDevice device;
        {
            Servo servo(device, 1000.0);
            servo.publish({});
            if (on_its_thread) {
                servo.start();
                for (std::uint64_t ticks = 0; ticks < 1300;) {
                    std::this_thread::sleep_for(std::chrono::milliseconds(10));
                    servo.drain([&ticks](const ServoSample &) { ++ticks; });
                }
                servo.stop();
                servo.stop(); // harmless
            } else {
                servo.advance(1200);
                ASSERT_GT(device.last_command.cancelled_resistance_Ohm.minCoeff(), 1.0); // it is up
                ASSERT_EQ(device.commands, 1200);
            }
        }
        EXPECT_GE(device.commands, on_its_thread ? 1301 : 1201);
        EXPECT_TRUE(on_its_thread || device.commands == 1201);
        EXPECT_EQ(device.last_command.e_W_V, Vector3::Zero());
        EXPECT_EQ(device.last_command.cancelled_resistance_Ohm, Vector3::Zero());
    }
}

TEST(Servo, LockstepIsReproducibleBitForBit) {
    const auto run = [] {
        simulated::SimulationOptions options;
        options.path.emplace(std::vector<simulated::HandPath::Point>{
            {1.2, kStart_m}, {1.7, Vector3(0.0, -0.01, 0.0)}, {2.2, Vector3(0.02, -0.01, 0.01)}});
        simulated::SimulatedPhantom device(testing::phantom_1_0(), options, kStart_m);
        const contact::HapticSurface mesh(
            testing::box_soup(Vector3(-0.05, -0.02, -0.05), Vector3(0.05, 0.0, 0.05)));
        ServoInputs inputs;
        inputs.surface = &mesh;
        Servo servo(device, 1000.0);
        servo.publish(inputs);
        servo.advance(2400);
        return rows_of(servo);
    };
    const std::vector<std::string> first = run();
    EXPECT_EQ(first.size(), 2400U);
    EXPECT_EQ(first, run());
}

TEST(Servo, CountsLostSamples) {
    RecordingDevice device;
    Servo servo(device, 1000.0);
    servo.advance(16'384 + 50);
    EXPECT_EQ(servo.lost_samples(), 50U);
    EXPECT_EQ(rows_of(servo).size(), 16'384U);
}

TEST(Servo, TuningFromAnotherThreadArrivesIntact) {
    RecordingDevice device;
    Servo servo(device, 5000.0);
    servo.start();
    // Consistent sets of inputs: the servo must report one of them.
    ServoInputs inputs;
    int seen = 0;
    for (int i = 0; seen < 1000; ++i) { // as long as it takes
        const bool even = i % 2 == 0;
        inputs.tuning.eta = even ? 0.25 : 0.75;
        inputs.tuning.map = even ? control::MotionMap::inverse : control::MotionMap::transpose;
        inputs.scene_id = even ? 2 : 3;
        servo.publish(inputs);
        servo.drain([&seen](const ServoSample &sample) {
            if (sample.scene_id != 0) {
                ++seen;
                EXPECT_EQ(sample.tuning.map == control::MotionMap::inverse, sample.scene_id == 2);
            }
        });
    }
    servo.stop();
}

/// Sends heartbeats for a while, pauses for longer than the monitor tolerates, then sends them
/// again.
std::vector<ServoSample> through_a_silence(device::HapticDevice &device) {
    Servo servo(device, 1000.0);
    ServoInputs inputs;
    inputs.limits.window_silence_s = 0.2;
    servo.start();
    std::vector<ServoSample> samples;
    const auto frame = [&](bool beats) {
        inputs.heartbeat += beats ? 1U : 0U;
        servo.publish(inputs);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        servo.drain([&samples](const ServoSample &sample) { samples.push_back(sample); });
    };
    const auto frames = [&](int count, bool beat) {
        for (int i = 0; i < count; ++i) {
            frame(beat);
        }
    };
    frames(20, true);
    frames(100, false);
    frames(20, true);
    servo.stop();
    return samples;
}

TEST(Servo, ASimulatedDeviceWaitsForASilentWindow) {
    simulated::SimulatedPhantom device(testing::phantom_1_0(), {}, kStart_m);
    const std::vector<ServoSample> samples = through_a_silence(device);
    std::uint64_t missed = 0;
    for (const ServoSample &sample : samples) {
        EXPECT_NE(sample.safety.state, SafetyState::tripped) << description(sample.safety);
        missed += sample.missed_deadlines;
    }
    EXPECT_GE(missed, 300U); // the half second of silence minus 0.1 s, plus those of a busy host
}

TEST(Servo, AnInvalidLimitPausesNoDevice) {
    for (const double silence_s : {-1.0, 0.0, static_cast<double>(NAN)}) {
        simulated::SimulatedPhantom device(testing::phantom_1_0(), {}, kStart_m);
        Servo servo(device, 1000.0);
        ServoInputs inputs;
        inputs.limits.window_silence_s = silence_s;
        inputs.heartbeat = 1; // the only heartbeat, well within the device's own limit
        servo.publish(inputs);
        servo.start();
        std::uint64_t ticks = 0;
        for (int i = 0; i < 2000 && ticks < 20; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            servo.drain([&ticks](const ServoSample &) { ++ticks; });
        }
        EXPECT_GE(ticks, 20U) << silence_s;
        servo.stop();
    }
}

TEST(Servo, AnotherDeviceStopsWhenTheWindowIsSilent) {
    simulated::SimulatedPhantom device(testing::phantom_1_0(), {}, kStart_m);
    testing::OwnClockDevice hardware(device, 1e-3);
    const std::vector<ServoSample> samples = through_a_silence(hardware);
    EXPECT_EQ(samples.back().safety.state, SafetyState::tripped);
    // A busy host may be the first cause; what matters is the stop.
    EXPECT_TRUE(samples.back().safety.cause == TripCause::window_silent ||
                samples.back().safety.cause == TripCause::missed_deadlines);
}

TEST(Servo, AnotherRateContinuesInTheSameState) {
    simulated::SimulatedPhantom device(testing::phantom_1_0(), {}, kStart_m);
    Servo servo(device, 1000.0);
    servo.publish({});
    servo.advance(1500);
    servo.set_rate(4000.0);
    servo.advance(400);
    EXPECT_THROW(servo.set_rate(1.0), InputError);
    EXPECT_EQ(servo.rate_hz(), 4000.0);
    servo.set_rate(500.0);
    servo.advance(50);
    std::vector<ServoSample> samples;
    servo.drain([&samples](const ServoSample &sample) { samples.push_back(sample); });
    ASSERT_EQ(samples.size(), 1950U);
    for (std::size_t i = 1; i < samples.size(); ++i) {
        const double period_s = i < 1500 ? 1e-3 : (i < 1900 ? 0.25e-3 : 2e-3);
        EXPECT_DOUBLE_EQ(samples[i].since_last_s, period_s);
        EXPECT_NEAR(samples[i].measured_s - samples[i - 1].measured_s, period_s, 1e-12);
        EXPECT_NEAR(samples[i].time_s - samples[i - 1].time_s, period_s, 1e-12);
        EXPECT_EQ(samples[i].tick, i);
    }
    EXPECT_EQ(samples.back().safety.state, SafetyState::running);
}

TEST(Servo, AnotherRateOnItsThreadKeepsSamplesAndState) {
    simulated::SimulatedPhantom device(testing::phantom_1_0(), {}, kStart_m);
    Servo servo(device, 1000.0);
    servo.publish({});
    servo.start();
    std::uint64_t next = 0;
    SafetyState state = SafetyState::waiting;
    const auto run_to = [&](std::uint64_t tick) {
        while (next < tick) {
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
            servo.drain([&](const ServoSample &sample) {
                EXPECT_EQ(sample.tick, next++);
                state = sample.safety.state;
            });
        }
    };
    run_to(1300);
    EXPECT_EQ(state, SafetyState::running);
    for (const double rate_hz : {2000.0, 250.0, 1000.0}) {
        servo.set_rate(rate_hz);
        run_to(next + 100);
        EXPECT_EQ(state, SafetyState::running);
    }
    servo.stop();
    EXPECT_EQ(servo.lost_samples(), 0U);
}

TEST(Servo, RejectsUnsupportedRates) {
    RecordingDevice device;
    for (const double good : {250.0, 10'000.0}) {
        EXPECT_NO_THROW(Servo(device, good));
    }
    for (const double bad : {249.9, 10'000.1, 0.0, -1.0, static_cast<double>(NAN)}) {
        EXPECT_THROW(Servo(device, bad), InputError);
    }
}

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

using testing::Plant;
using testing::PlantedDevice;

constexpr int kPressing = 1900; // ticks, by when the tip is deep in the plate

/// A hand presses the tip of a device with a planted bug into a plate.
struct Pressed {
    explicit Pressed(Plant plant, double servo_hz = 1000.0)
        : device(plant, hand()), servo(device, servo_hz) {
        inputs.surface = &plate;
        inputs.scene_id = 1;
        servo.publish(inputs);
    }

    static std::vector<simulated::HandPath::Point> hand() {
        return {{1.2, testing::kPlantedStart_m}, {1.6, Vector3(0.0, -0.01, 0.0)}};
    }

    void take_in() {
        servo.drain([&](const ServoSample &sample) { samples.push_back(sample); });
    }

    /// Waits until the servo's thread has completed `ticks` more ticks.
    void wait_for(std::size_t ticks) {
        for (const std::size_t end = samples.size() + ticks; samples.size() < end; take_in()) {
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
    }

    contact::HapticSurface plate{
        testing::box_soup(Vector3(-0.05, -0.02, -0.05), Vector3(0.05, 0.0, 0.05))};
    PlantedDevice device;
    Servo servo;
    ServoInputs inputs;
    std::vector<ServoSample> samples;
};

/// From the failure on the device received only braking commands, and before that it was driven.
void expect_braked(const PlantedDevice &device) {
    const std::vector<device::DeviceCommand> &received = device.received();
    const std::size_t failed = device.received_before_failure();
    ASSERT_GT(failed, 0U);
    ASSERT_LT(failed, received.size());
    EXPECT_GT(received[failed - 1].e_W_V.norm(), 0.1);
    EXPECT_GT(received[failed - 1].cancelled_resistance_Ohm.minCoeff(), 1.0);
    for (std::size_t i = failed; i < received.size(); ++i) {
        ASSERT_EQ(received[i].mode, device::CommandMode::brake) << i - failed;
        ASSERT_TRUE(received[i].e_W_V.isZero(0.0)) << i - failed;
        ASSERT_TRUE(received[i].cancelled_resistance_Ohm.isZero(0.0)) << i - failed;
    }
}

void expect_said(const SafetyStatus &status, const testing::PlantedLimit &line) {
    EXPECT_EQ(status.state, SafetyState::tripped);
    EXPECT_EQ(status.cause, TripCause::assertion);
    EXPECT_STREQ(status.failure.condition, line.condition);
    EXPECT_STREQ(status.failure.file, "tests/support/servo_devices.h");
    EXPECT_EQ(status.failure.line, line.line);
    EXPECT_EQ(description(status),
              "internal error, assertion failed at tests/support/servo_devices.h:" +
                  std::to_string(line.line) + ": " + line.condition + "; restart the program");
}

class FailedAssertion : public ::testing::TestWithParam<Plant> {};

TEST_P(FailedAssertion, TheDeviceReceivesOnlyBrakingCommandsFromThenOn) {
    Pressed rig(GetParam());
    rig.servo.advance(kPressing);
    rig.device.arm();
    rig.servo.advance(500);
    rig.take_in();
    expect_braked(rig.device);
    // No tick is missing, and all since report the failure.
    ASSERT_EQ(rig.samples.size(), kPressing + 500U);
    for (std::size_t i = 0; i < rig.samples.size(); ++i) {
        ASSERT_EQ(rig.samples[i].tick, i);
        ASSERT_EQ(rig.samples[i].safety.state == SafetyState::tripped, i >= kPressing) << i;
    }
    expect_said(rig.samples[kPressing].safety, rig.device.line());
    expect_said(rig.samples.back().safety, rig.device.line());
    EXPECT_TRUE(rig.samples.back().command.e_W_V.isZero(0.0));
    EXPECT_NE(rig.samples.back().counts, rig.samples[kPressing].counts); // it still measures
    EXPECT_NE(rig.samples.back().tip_m, rig.samples[kPressing].tip_m);
}

TEST_P(FailedAssertion, OnTheServosThreadToo) {
    Pressed rig(GetParam(), 4000.0);
    rig.servo.start();
    rig.wait_for(4 * std::size_t{kPressing});
    ASSERT_EQ(rig.samples.back().safety.state, SafetyState::running);
    rig.device.arm();
    while (rig.samples.back().safety.state != SafetyState::tripped) {
        rig.wait_for(1);
    }
    rig.wait_for(1000);
    rig.servo.stop();
    rig.take_in();
    expect_braked(rig.device);
    expect_said(rig.samples.back().safety, rig.device.line());
    for (std::size_t i = 0; i < rig.samples.size(); ++i) {
        ASSERT_EQ(rig.samples[i].tick, i);
    }
}

INSTANTIATE_TEST_SUITE_P(Servo, FailedAssertion,
                         ::testing::Values(Plant::in_read, Plant::in_update, Plant::in_write),
                         [](const auto &of) { return testing::name_of(of.param); });

TEST(ServoAssertion, OnlyARestartClearsIt) {
    Pressed rig(Plant::in_update);
    rig.servo.advance(kPressing);
    rig.device.arm();
    rig.servo.advance(1);
    rig.inputs.reset_count = 1;
    rig.servo.publish(rig.inputs);
    rig.servo.advance(100);
    rig.inputs.requested_stop = rig.inputs.released_stop = 1;
    rig.inputs.reset_count = 2;
    rig.inputs.release = true;
    rig.inputs.scene_id = 2; // tells the publisher that the first surface is no longer used
    rig.inputs.surface = nullptr;
    rig.servo.publish(rig.inputs);
    rig.servo.advance(100);
    rig.servo.set_rate(2000.0);
    rig.inputs.release = false;
    rig.servo.publish(rig.inputs);
    rig.servo.start(); // continues in the same state
    rig.take_in();
    EXPECT_EQ(rig.samples.back().scene_id, 2U);
    rig.wait_for(3000);
    rig.servo.pause();
    rig.inputs.reset_count = 3;
    rig.servo.publish(rig.inputs);
    rig.servo.resume();
    rig.wait_for(3000);
    rig.servo.stop();
    rig.take_in();
    expect_braked(rig.device);
    expect_said(rig.samples.back().safety, rig.device.line());
}

TEST(ServoAssertion, ASecondFailureWhileBrakingEndsTheTicksNotTheProgram) {
    for (const bool on_a_thread : {false, true}) {
        Pressed rig(Plant::in_read);
        rig.servo.advance(kPressing);
        rig.device.arm(2);
        if (on_a_thread) {
            rig.servo.start();
            while (rig.device.failures() < 2) {
                std::this_thread::sleep_for(std::chrono::milliseconds(2));
            }
        } else {
            rig.servo.advance(100);
        }
        rig.servo.stop();
        expect_braked(rig.device);
        EXPECT_EQ(rig.device.failures(), 2);
        // Once at each failure, and at the end.
        EXPECT_EQ(rig.device.received().size(), rig.device.received_before_failure() + 3);
    }
}

TEST(ServoAssertion, OpenWindingsStayOpen) {
    Pressed rig(Plant::in_update);
    rig.servo.advance(kPressing);
    rig.device.report(device::BoardFaults::kAmplifier);
    rig.servo.advance(1);
    ASSERT_EQ(rig.device.received().back().mode, device::CommandMode::open);
    rig.device.arm();
    rig.servo.advance(10);
    EXPECT_EQ(rig.device.failures(), 1);
    EXPECT_EQ(rig.device.received().back().mode, device::CommandMode::open);
    rig.take_in();
    expect_said(rig.samples.back().safety, rig.device.line()); // no longer the board's fault
}

TEST(ServoAssertionDeathTest, IfTheSafeCommandFailsTooTheProgramEnds) {
    Pressed rig(Plant::in_read);
    rig.servo.advance(kPressing);
    const auto go_on = [&] {
        rig.device.arm();
        rig.device.refuse_to_brake();
        rig.servo.advance(1);
    };
    EXPECT_DEATH(go_on(), "^told to brake\nspringdrive: assertion failed: !refuses_");
}

TEST(ServoAssertionDeathTest, AnUnguardedLoopEndsTheProgram) {
    PlantedDevice device(Plant::in_update, Pressed::hand());
    ServoLoop loop(device, 1e-3);
    static_cast<void>(loop.tick({}));
    device.arm();
    EXPECT_DEATH(static_cast<void>(loop.tick({})),
                 "assertion failed: .*, tests/support/servo_devices\\.h:");
}

} // namespace
} // namespace springdrive::servo

// Devices for tests of the servo: one that does not wait for it, and one with a planted bug.
#pragma once

#include "base/assertions.h"
#include "device/core/haptic_device.h"
#include "device/simulated/simulated_phantom.h"
#include "tests/support/devices.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace springdrive::testing {

/// Imitates hardware: a device that does not wait for the servo. Its clock is the computer's, and
/// its plant advances by the number of periods that have passed.
class OwnClockDevice final : public device::ForwardingDevice {
public:
    /// @param max_periods  by which the plant advances at most in one read; after a longer gap it
    ///                      lags
    OwnClockDevice(device::HapticDevice &device, double period_s, int max_periods = 100)
        : device::ForwardingDevice(device), period_s_(period_s), max_periods_(max_periods) {}

    [[nodiscard]] device::DeviceClock clock() const override { return device::DeviceClock::own; }
    [[nodiscard]] device::Measurement read() noexcept override {
        const double now_s = std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
        const double passed = started_ ? std::round((now_s - last_s_) / period_s_) : 1.0;
        last_s_ = now_s;
        started_ = true;
        device::Measurement measured = device::ForwardingDevice::read();
        for (int i = 1; i < std::min(static_cast<int>(std::min(passed, 1e6)), max_periods_); ++i) {
            measured = device::ForwardingDevice::read();
        }
        measured.time_s = now_s;
        return measured;
    }

private:
    using Clock = std::chrono::steady_clock;

    double period_s_;
    int max_periods_;
    bool started_ = false;
    double last_s_ = 0.0;
};

inline const Vector3 kPlantedStart_m(0.0, 0.02, 0.0);

/// Position in a tick.
enum class Plant : std::uint8_t {
    in_read,
    in_update, ///< while the law is evaluated
    in_write,  ///< after the command is computed, before the device has it
};

[[nodiscard]] inline std::string name_of(Plant plant) {
    return plant == Plant::in_read ? "InRead" : plant == Plant::in_update ? "InUpdate" : "InWrite";
}

struct PlantedLimit {
    const char *condition;
    int line;
};

/// A simulated device with a planted bug: an assertion that fails on request, in a chosen part of
/// the servo's tick. It stores the commands that it receives.
class PlantedDevice final : public device::ForwardingDevice {
public:
    PlantedDevice(Plant plant, std::vector<simulated::HandPath::Point> hand)
        : device::ForwardingDevice(simulated_with(simulated::HandPath(std::move(hand)))),
          plant_(plant) {
        received_.reserve(1U << 17U);
    }

    /// Fails `times` times from now on. Any thread.
    void arm(int times = 1) { to_come_.store(times); }
    void refuse_to_brake() { refuses_ = true; }
    void report(std::uint16_t faults) { faults_.bits = faults; }

    // All but `failures` only after the servo has stopped.
    [[nodiscard]] const std::vector<device::DeviceCommand> &received() const { return received_; }
    [[nodiscard]] std::size_t received_before_failure() const { return received_before_failure_; }
    [[nodiscard]] int failures() const { return failures_.load(); }
    [[nodiscard]] PlantedLimit line() const {
        return plant_ == Plant::in_read     ? kInRead
               : plant_ == Plant::in_update ? kInUpdate
                                            : kInWrite;
    }

    [[nodiscard]] device::Measurement read() noexcept override {
        answering_ = std::thread::id();
        SPRINGDRIVE_ASSERT(!fails(Plant::in_read));
        device::Measurement measured = device::ForwardingDevice::read();
        measured.faults = faults_;
        answering_ = std::this_thread::get_id(); // until `write`
        return measured;
    }
    static constexpr PlantedLimit kInRead{"!fails(Plant::in_read)", __LINE__ - 6};

    /// Also called by the window's thread.
    [[nodiscard]] device::DeviceClock clock() const override {
        SPRINGDRIVE_ASSERT(!is_answering() || !fails(Plant::in_update));
        return device::ForwardingDevice::clock();
    }
    static constexpr PlantedLimit kInUpdate{"!is_answering() || !fails(Plant::in_update)",
                                            __LINE__ - 4};

    void write(const device::DeviceCommand &command) noexcept override {
        answering_ = std::thread::id();
        const bool brakes = command.mode != device::CommandMode::drive;
        SPRINGDRIVE_ASSERT(brakes || !fails(Plant::in_write));
        received_.push_back(command);
        if (refuses_ && brakes) {
            std::fputs("told to brake\n", stderr);
        }
        SPRINGDRIVE_ASSERT(!refuses_ || !brakes);
        device::ForwardingDevice::write(command);
    }
    static constexpr PlantedLimit kInWrite{"brakes || !fails(Plant::in_write)", __LINE__ - 8};

private:
    static std::unique_ptr<device::HapticDevice> simulated_with(const simulated::HandPath &hand) {
        simulated::SimulationOptions options;
        options.path = hand;
        return std::make_unique<simulated::SimulatedPhantom>(phantom_1_0(), options,
                                                             kPlantedStart_m);
    }

    /// Whether the calling thread is between `read` and `write`, where it computes the command.
    [[nodiscard]] bool is_answering() const noexcept {
        return answering_.load() == std::this_thread::get_id();
    }

    [[nodiscard]] bool fails(Plant here) const noexcept {
        if (here != plant_ || to_come_.load() == 0) {
            return false;
        }
        to_come_.fetch_sub(1);
        if (failures_.fetch_add(1) == 0) {
            received_before_failure_ = received_.size();
        }
        return true;
    }

    Plant plant_;
    std::vector<device::DeviceCommand> received_;
    std::atomic<std::thread::id> answering_{};
    bool refuses_ = false;
    device::BoardFaults faults_;
    mutable std::atomic<int> to_come_{0};
    mutable std::atomic<int> failures_{0};
    mutable std::size_t received_before_failure_ = 0;
};

} // namespace springdrive::testing

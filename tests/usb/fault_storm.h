// A whole servo on an emulated board, and one random fault of that board: whether it is named, and
// whether it reaches the motors as force.
//
//   rest ── starting ── running, free or pressing ──► fault, for a while ──► afterwards
//
// In every tick, by the true state of the plant, which no fault scales: no winding carries more
// than the board's trip current; the tip force of the true currents at the true angles is not above
// the device's limit for longer than 20 ms; the tip is not faster than 2.2 m/s; and what has
// tripped stays so.
#pragma once

#include "device/usb/driver/usb_device.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/servo/servo_loop.h"
#include "tests/support/emulated_port.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>

namespace springdrive::testing {

/// By the board's frame clock: T passes in each tick.
class ServoOnBoard {
public:
    /// Zeroed at the true angles, once the tip hangs at rest.
    explicit ServoOnBoard(const device::DeviceDescription &description,
                          const emulator::EmulatedBoardOptions &options, double period_s = 1e-3)
        : board(description, options), port(new EmulatedPort(board)),
          device(std::unique_ptr<usb::BoardPort>(port), description, "", period_s,
                 usb::Pacing::reports),
          loop(device, period_s) {
        constexpr double kSettling_s = 0.3;
        for (int i = 0; i < ticks_in(kSettling_s); ++i) {
            device::DeviceCommand command = device::DeviceCommand::braking();
            command.number = device.read().number;
            device.write(command);
        }
        device.zero(truth().theta_rad);
    }

    const servo::ServoSample &tick() {
        last = loop.tick(inputs);
        return last;
    }
    void run(double seconds) {
        for (int i = 0; i < ticks_in(seconds); ++i) {
            tick();
        }
    }
    [[nodiscard]] double period_s() const { return loop.period_s(); }
    [[nodiscard]] int ticks_in(double seconds) const {
        return static_cast<int>(std::lround(seconds / period_s()));
    }

    [[nodiscard]] const simulated::SimulatedPhantom::Truth &truth() const {
        return board.plant().phantom().truth();
    }
    [[nodiscard]] board::State state() const { return board.board().loop().state(); }
    [[nodiscard]] bool has_tripped() const {
        return last.safety.state == servo::SafetyState::tripped;
    }

    emulator::EmulatedBoard board;
    EmulatedPort *port; ///< of the device
    usb::UsbDevice device;
    servo::ServoLoop loop;
    servo::ServoInputs inputs; ///< of the next tick
    servo::ServoSample last;
};

/// A fault, and what the servo does when it comes.
struct StormCase {
    device::Fault fault; ///< begins and ends by the servo's time
    bool presses = false;
    control::Tuning tuning;
    double period_s = 1e-3;
    double delay_periods = 0.3;
    double press_s = 0.0; ///< when the hand moves
    double until_s = 0.0;
    Vector3 start_m{Vector3::Zero()};
    Vector3 target_m{Vector3::Zero()};                       ///< of the hand
    double lift_s = std::numeric_limits<double>::infinity(); ///< when it goes on,
    Vector3 lifted_m{Vector3::Zero()};                       ///< to here
    device::HandParameters hand;
    std::uint64_t seed = 1; ///< of the packets' faults

    [[nodiscard]] std::string description() const;
};

/// Kinds cycle with the number of the case; all else is random.
[[nodiscard]] StormCase random_storm_case(std::uint64_t seed, int number);

/// What became of it.
struct StormOutcome {
    servo::SafetyStatus safety;
    double tripped_after_s = 0.0; ///< since the fault began
    bool was_driving = false;     ///< the board, when the fault began
    std::uint64_t struck = 0;     ///< packets
    device::LinkStatus before;    ///< counters
    device::LinkStatus after;
    double largest_A = 0.0;
    double largest_N = 0.0;       ///< of the true tip force
    double longest_over_s = 0.0;  ///< above its limit
    double largest_m_per_s = 0.0; ///< of the tip
    std::string broken;           ///< an invariant, in words; empty if none was
};

[[nodiscard]] StormOutcome outcome_of(const StormCase &what);

/// In words, where an outcome is not among those that the documentation names for the fault.
[[nodiscard]] std::string misnaming(const StormCase &what, const StormOutcome &outcome);

/// "drop in: stale_measurement", "crossed-motors: tolerated".
[[nodiscard]] std::string summary(const StormCase &what, const StormOutcome &outcome);

} // namespace springdrive::testing

// A device's self-test, one tick after the other, so that a window and a command can both show it
// while it goes on:
//
//   rest ──► pulses on each winding, several times ──► motion by hand from stop to stop ──► report
//
// The device brakes all the time, except for the pulses, whose limits are the board's own.
#pragma once

#include "device/core/haptic_device.h"
#include "engine/commissioning/device_checks.h"

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace springdrive::commissioning {

/// What moves a device where a person is asked to, such as a simulated hand: called once, when the
/// motion begins. Empty: a person moves it.
/// @param longest_s  that the motion may last
/// @return how long it lasts [s]
using Mover = std::function<double(double longest_s)>;

struct SelfTestOptions {
    /// At an R of 2.18 Ω, 0.37 A or 0.8 N at the tip of a PHANTOM 1.0.
    device::PulseOrder pulse{0.8, 8e-3};
    int repeats = 4; ///< of the pulses
    double rest_s = 0.5;
    bool has_motion = true; ///< otherwise it ends with the pulses
    /// Whoever begins it lets the board go on after a stop that it has latched already.
    bool lets_go_on = false;
    double longest_motion_s = 90.0;
};

enum class SelfTestStage : std::uint8_t { rest, pulses, motion, done };

struct SelfTestReport {
    bool is_complete = false; ///< went through all stages that were asked for
    bool has_motion = false;  ///< `motion` is valid
    WindingReport windings;   ///< if there are `pulses`
    std::vector<device::PulseResult> pulses;
    MotionReport motion;
    std::vector<Finding> findings; ///< all

    [[nodiscard]] bool has_passed() const { return is_complete && findings.empty(); }
};

class SelfTest {
public:
    /// @param device  has a bench, and is read and written by nobody else; outlives this
    /// @param mover   in place of a person
    explicit SelfTest(device::HapticDevice &device, const SelfTestOptions &options = {},
                      Mover mover = {});

    /// One tick: reads a measurement, answers by braking. The first ones reset what the board has
    /// latched before, as BoardReset permits. @return whether there is more to do
    /// @throw InputError if the board does not answer any more, or refuses the pulses
    bool step();

    [[nodiscard]] SelfTestStage stage() const { return stage_; }
    /// What the person shall do now.
    [[nodiscard]] std::string instruction() const;
    /// Whether the device has been everywhere.
    [[nodiscard]] bool has_reached_all() const { return motion_.missing().empty(); }
    [[nodiscard]] double share() const; ///< of the present stage

    /// The person has moved the device as far as it goes. Ignored in any other stage.
    void finish_motion();

    /// The rotors' angles of the last tick, for display.
    [[nodiscard]] Vector3 theta_rad() const;

    [[nodiscard]] SelfTestReport report() const;

private:
    void require_news(const device::Measurement &measured);
    void rest(const device::Measurement &measured);
    void start_pulses();
    void pulse();
    void move(const device::Measurement &measured);

    device::HapticDevice &device_;
    device::Bench &bench_;
    SelfTestOptions options_;
    Mover mover_;
    std::array<std::int32_t, 3> counts_{}; ///< of the last tick
    SelfTestStage stage_ = SelfTestStage::rest;
    double stage_began_s_ = -1.0; ///< by the device's time; before the first measurement
    double now_s_ = 0.0;
    int ticks_ = 0;
    device::BoardReset reset_;
    std::vector<device::PulseResult> pulses_;
    MotionCheck motion_;
    bool is_complete_ = false;
    int silent_reads_ = 0; ///< one after the other
    std::array<std::int32_t, 3> rest_counts_{};
    Vector3 rest_sum_A_{Vector3::Zero()};
    int rest_ticks_ = 0;
    std::vector<Finding> faults_; ///< of the board
};

} // namespace springdrive::commissioning

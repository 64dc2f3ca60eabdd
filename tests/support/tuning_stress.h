// Stress test with changes to a servo on its own thread: 10,000 sets of random valid inputs per
// second, while a hand presses on one of three surfaces. Every sample is checked.
//
// Each set encodes a serial number in several fields, so that a torn set would show in the samples:
// in limits that trip nothing, in K_D and η, which are tied to K_P and α, and in α of
// AlphaMode::global.
#pragma once

#include "device/simulated/simulated_phantom.h"
#include "engine/control/haptic_law.h"
#include "engine/servo/servo.h"

#include <array>
#include <cstdint>
#include <random>
#include <string>

namespace springdrive::testing {

/// Results of a run.
struct StressFigures {
    std::uint64_t published = 0;
    std::uint64_t samples = 0;
    std::uint64_t felt = 0;   ///< with voltage on and the tip touching
    std::uint64_t scenes = 0; ///< that became active
    std::uint64_t trips = 0;  ///< random tunings are not all stable
    std::uint64_t faults = 0; ///< failed expectations; the first few are reported
    std::array<int, servo::kTripCauseNames.size()> by_cause{};
    double max_step_V = 0.0; ///< of e_W due to a change in a tick

    [[nodiscard]] std::string text() const;
};

class TuningStress {
public:
    explicit TuningStress(double servo_hz);

    StressFigures run(double seconds);

private:
    void publish();
    void lift_and_press(const servo::ServoSample &sample);
    void check(const servo::ServoSample &sample);
    void check_set(const servo::ServoSample &sample);
    void check_step(const servo::ServoSample &sample);
    void expect(bool good, const servo::ServoSample &sample, const char *what);
    [[nodiscard]] Vector3 requested_V(const servo::ServoSample &state,
                                      const servo::ServoSample &tuned,
                                      const control::Configuration &now) const;

    simulated::SimulatedPhantom device_;
    control::HapticLaw law_;
    Vector3 supply_V_;
    double period_s_;
    std::array<contact::HapticSurface, 3> surfaces_;
    std::mt19937 random_{61};
    servo::ServoInputs inputs_;
    StressFigures figures_;
    bool has_previous_ = false;
    servo::ServoSample before_;
    std::uint64_t next_reset_ = 0; ///< no earlier than in this tick
    servo::Servo servo_;           ///< last member, so that it stops first
};

} // namespace springdrive::testing

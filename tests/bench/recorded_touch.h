// A touch of the simulated device, played once and kept, so that what each step of a servo tick
// costs can be measured on the states that it has to deal with.
#pragma once

#include "engine/lab/rig/servo_rig.h"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace springdrive::bench {

struct RecordedTouch {
    /// Until the gains are up and the hand is where it was sent to; not worth measuring.
    static constexpr std::size_t kBefore = 2500;
    static constexpr std::size_t kTicks = 8000; ///< with those before

    rig::Scenario scenario;
    // One for each tick.
    std::vector<device::Measurement> states;
    std::vector<servo::ServoSample> samples;

    /// Before its first tick; made anew, it goes the same way.
    [[nodiscard]] std::unique_ptr<rig::ServoRig> rig() const;
};

/// Played when it is first asked for: "free", "plate", "organic", "sphere shape", or as
/// `test_surface_named` has it.
/// @throw std::runtime_error where it is not the touch that it should be
[[nodiscard]] const RecordedTouch &recorded_touch(const std::string &name);

} // namespace springdrive::bench

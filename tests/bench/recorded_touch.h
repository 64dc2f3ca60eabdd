// A recorded touch of the simulated device, so that the cost of each step of a servo tick can be
// measured on realistic states.
#pragma once

#include "engine/lab/rig/servo_rig.h"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace springdrive::bench {

struct RecordedTouch {
    /// Until the gains are up and the hand has reached its target; not measured.
    static constexpr std::size_t kBefore = 2500;
    static constexpr std::size_t kTicks = 8000; ///< with those before

    rig::Scenario scenario;
    // One for each tick.
    std::vector<device::Measurement> states;
    std::vector<servo::ServoSample> samples;

    /// Before its first tick; a new one follows the same path.
    [[nodiscard]] std::unique_ptr<rig::ServoRig> rig() const;
    /// Before the first tick that is measured.
    [[nodiscard]] std::unique_ptr<rig::ServoRig> rig_in_touch() const;
};

/// Recorded at the first request: "free", "plate", "organic", "sphere shape", or a name of
/// `test_surface_named`.
/// @throw std::runtime_error where the recorded touch is not as expected
[[nodiscard]] const RecordedTouch &recorded_touch(const std::string &name);

} // namespace springdrive::bench

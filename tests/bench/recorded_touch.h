// A touch of the simulated device, played once and kept, so that what each step of a servo tick
// costs can be measured on the states that it has to deal with.
#pragma once

#include "device/simulated/hand_path.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/servo/servo_loop.h"

#include <cstddef>
#include <string>
#include <vector>

namespace springdrive::bench {

/// A servo in lockstep on a device that a hand leads along a path.
struct ServoRig {
    ServoRig(const device::DeviceDescription &description, const simulated::HandPath &path,
             const contact::HapticSurface &surface);

    servo::ServoSample tick() { return loop.tick(sealed_inputs); }

    simulated::SimulatedPhantom device;
    servo::ServoLoop loop;
    servo::ServoInputs sealed_inputs;
};

struct RecordedTouch {
    /// Until the gains are up and the hand is where it was sent to; not worth measuring.
    static constexpr std::size_t kBefore = 2500;
    static constexpr std::size_t kTicks = 8000; ///< with those before

    device::DeviceDescription description;
    contact::HapticSurface surface;
    simulated::HandPath path;
    // One for each tick.
    std::vector<device::Measurement> states;
    std::vector<servo::ServoSample> samples;

    [[nodiscard]] ServoRig rig() const { return {description, path, surface}; }
};

/// Played when it is first asked for: "free", "plate", "organic", "sphere shape", or as
/// `test_surface_named` has it.
/// @throw std::runtime_error where it is not the touch that it should be
[[nodiscard]] const RecordedTouch &recorded_touch(const std::string &name);

} // namespace springdrive::bench

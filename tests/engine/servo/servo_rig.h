// A simulated device, a surface and a servo that is ticked by hand, for the tests of the loop.
#pragma once

#include "device/simulated/simulated_phantom.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/servo/servo_loop.h"
#include "tests/support/devices.h"
#include "tests/support/surfaces.h"

#include <cmath>
#include <utility>
#include <vector>

namespace springdrive::testing {

inline constexpr double kPeriod_s = 1e-3;
/// The servo waits for a tip at rest for 0.1 s and ramps for 1 s: by then it runs.
inline constexpr double kStartUp_s = 1.2;
inline const Vector3 kStart_m(0.0, 0.02, 0.0);

/// A device, a surface and a servo ticked by hand.
struct Rig {
    explicit Rig(const simulated::SimulationOptions &options, contact::TriangleSoup soup = {})
        : device(phantom_1_0(), options, kStart_m), loop(device, options.servo_period_s),
          mesh(std::move(soup)) {
        inputs.surface = &mesh;
    }

    servo::ServoSample tick() { return loop.tick(servo::sealed(inputs)); }

    void run(double seconds) {
        for (int i = 0; i < static_cast<int>(std::round(seconds / loop.period_s())); ++i) {
            tick();
        }
    }

    simulated::SimulatedPhantom device;
    servo::ServoLoop loop;
    contact::HapticSurface mesh;
    servo::ServoInputs inputs;
};

/// A plate whose top is at y = 0, wide enough for every slide.
inline contact::TriangleSoup plate() {
    return box_soup(Vector3(-0.1, -0.02, -0.06), Vector3(0.1, 0.0, 0.06));
}

/// What is tested here is the law: a plant without friction and weight shows it plainly. The hand
/// sets out when the servo has started up: the path's times count from there.
inline simulated::SimulationOptions following(std::vector<simulated::HandPath::Point> points) {
    for (simulated::HandPath::Point &point : points) {
        point.time_s += kStartUp_s;
    }
    simulated::SimulationOptions options;
    options.effects = simulated::PlantEffects::none();
    options.path.emplace(std::move(points));
    return options;
}

} // namespace springdrive::testing

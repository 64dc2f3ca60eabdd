// The rig of the servo loop's tests.
#pragma once

#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/rig/servo_rig.h"
#include "tests/support/devices.h"
#include "tests/support/surfaces.h"

#include <utility>
#include <vector>

namespace springdrive::testing {

inline constexpr double kPeriod_s = 1e-3;
/// The servo waits for a tip at rest for 0.1 s and ramps for 1 s: by then it runs.
inline constexpr double kStartUp_s = 1.2;
inline const Vector3 kStart_m(0.0, 0.02, 0.0);

/// The first device from rest at `kStart_m`, with a mesh of its own to touch.
class Rig : public rig::ServoRig {
public:
    explicit Rig(const simulated::SimulationOptions &options, contact::TriangleSoup soup = {})
        : ServoRig(phantom_1_0(), options, kStart_m), mesh_(std::move(soup)) {
        inputs.surface = &mesh_;
    }

private:
    contact::HapticSurface mesh_;
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

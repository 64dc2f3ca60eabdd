// The test rig of the servo loop.
#pragma once

#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/rig/servo_rig.h"
#include "tests/support/devices.h"
#include "tests/support/surfaces.h"

#include <utility>
#include <vector>

namespace springdrive::testing {

inline constexpr double kPeriod_s = 1e-3;
/// The servo waits for 0.1 s of rest and ramps up for 1 s: by then it runs.
inline constexpr double kStartUp_s = 1.2;
inline const Vector3 kStart_m(0.0, 0.02, 0.0);

/// The PHANTOM 1.0 from rest at `kStart_m`, with its own mesh to touch.
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

/// To test the law, the plant has no friction and weight. The hand starts to move when the servo
/// has started up: the path's times count from there.
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

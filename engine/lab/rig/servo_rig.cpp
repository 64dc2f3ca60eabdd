#include "engine/lab/rig/servo_rig.h"

#include "device/core/phantom/kinematics.h"

#include <cmath>
#include <utility>

namespace springdrive::rig {

ServoRig::ServoRig(const device::DeviceDescription &device,
                   const simulated::SimulationOptions &simulation, const Vector3 &start_tip_m,
                   const contact::HapticSurface *surface)
    : description_(device), simulation_(simulation),
      phantom_(std::in_place, device, simulation, start_tip_m), device_(*phantom_),
      loop_(device_, simulation.servo_period_s) {
    inputs.surface = surface;
}

ServoRig::ServoRig(const Scenario &scenario)
    : ServoRig(scenario.device, scenario.simulation, scenario.start_m, scenario.surface.get()) {
    surface_ = scenario.surface;
    inputs.tuning = scenario.tuning;
}

const servo::ServoSample &ServoRig::tick(const servo::TickTiming &timing) noexcept {
    measured_ = loop_.read();
    last = loop_.update(measured_, inputs, timing);
    loop_.write();
    return last;
}

const servo::ServoSample &ServoRig::late_tick(int missed) noexcept {
    device_.pass_by(missed);
    return tick();
}

void ServoRig::run(double seconds) noexcept {
    for (long i = std::lround(seconds / loop_.period_s()); i > 0; --i) {
        tick();
    }
}

void ServoRig::let_go() {
    const simulated::SimulatedPhantom::Truth before = phantom_->truth();
    simulation_.hand = {0.0, 0.0, 0.0, 0.0, 1.0};
    phantom_.emplace(description_, simulation_, before.tip_m);
    phantom_->set_in_motion(
        device::joint_from_motor(description_.geometry, before.theta_rate_rad_per_s),
        before.current_A);
    device_.continue_numbering();
}

} // namespace springdrive::rig

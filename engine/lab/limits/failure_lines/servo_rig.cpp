#include "engine/lab/limits/failure_lines/servo_rig.h"

#include "device/core/phantom/kinematics.h"
#include "engine/lab/limits/failure_lines/failing_shapes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace springdrive::limits {

namespace {

constexpr double kRoom_m = 0.05;
constexpr double kOff_m = 3e-3; ///< from each wall at first
/// The servo waits for a tip at rest for 0.1 s and ramps for 1 s: by then it runs.
constexpr double kStartUp_s = 1.2;

simulated::SimulationOptions options_of(const ServoRigOptions &rig) {
    const loops::Hand &hand = rig.which.hands.front();
    simulated::SimulationOptions options;
    options.servo_period_s = rig.which.period_s;
    options.delay_periods = rig.which.delay_periods;
    options.quantised_encoders = false;
    options.hand = {hand.mass_kg, hand.damping_Ns_per_m, hand.stiffness_N_per_m, rig.hand_force_N,
                    1.0};
    options.effects = simulated::PlantEffects::none();
    options.effects.viscous_friction = true;
    options.effects.amplifier_limits = true;
    return options;
}

Vector3 corner_of(const loops::StabilityCase &which) {
    return device::tip_position_m(which.device.geometry, which.q_rad);
}

/// A box that is touched from within, its lowest corner at `corner_m`.
contact::TriangleSoup room(const Vector3 &corner_m) {
    contact::TriangleSoup soup = solid_box(corner_m, corner_m + Vector3::Constant(kRoom_m));
    for (auto &triangle : soup.triangles) {
        std::swap(triangle[1], triangle[2]);
    }
    return soup;
}

} // namespace

device::Measurement FailingDevice::read() noexcept {
    const device::Measurement truth = plant_->read();
    if (silent_ > 0 || lost_ > 0) {
        answer_.arrival = device::Arrival::absent;
        answer_.health = lost_ > 0 ? device::DeviceHealth::lost : device::DeviceHealth::ok;
        silent_ = std::max(0, silent_ - 1);
        lost_ = std::max(0, lost_ - 1);
    } else {
        answer_ = truth;
        answer_.number += numbers_before_;
    }
    return answer_;
}

void FailingDevice::let_go() {
    const simulated::SimulatedPhantom::Truth before = plant_->truth();
    numbers_before_ = answer_.number;
    options_.hand = {0.0, 0.0, 0.0, 0.0, 1.0};
    plant_.emplace(device_, options_, before.tip_m);
    plant_->set_in_motion(device::joint_from_motor(device_.geometry, before.theta_rate_rad_per_s),
                          before.current_A);
    plant_->write(heard_); // the amplifiers hold it
}

ServoRig::ServoRig(const ServoRigOptions &options)
    : device(options.which.device, options_of(options),
             corner_of(options.which) + Vector3::Constant(kOff_m)),
      hand_N_per_m_(options.which.hands.front().stiffness_N_per_m),
      corner_m_(corner_of(options.which)), target_m_(corner_m_ + Vector3::Constant(kOff_m)),
      walls_(room(corner_m_)), loop_(device, options.which.period_s) {
    inputs.surface = &walls_;
    inputs.tuning = options.which.tuning;
    run(kStartUp_s);
}

servo::ServoSample ServoRig::tick(int missed) {
    for (int i = 0; i < missed; ++i) {
        device.pass_by();
    }
    last = loop_.tick(servo::sealed(inputs));
    return last;
}

void ServoRig::run(double seconds) {
    for (long i = std::lround(seconds / loop_.period_s()); i > 0; --i) {
        static_cast<void>(tick());
    }
}

void ServoRig::press(double force_N) {
    constexpr double kSettles_s = 0.6;
    target_m_ = corner_m_ - Vector3::Constant(force_N / hand_N_per_m_ / std::sqrt(3.0));
    device.set_hand_target(target_m_);
    run(kSettles_s);
}

void ServoRig::nudge() {
    constexpr double kNudge_m = 1e-4;
    target_m_ += kNudge_m * Vector3(0.6, 0.64, 0.48);
    device.set_hand_target(target_m_);
}

} // namespace springdrive::limits

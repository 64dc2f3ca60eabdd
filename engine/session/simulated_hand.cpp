#include "engine/session/simulated_hand.h"

#include "base/bisection.h"
#include "device/core/phantom/kinematics.h"

namespace springdrive::session {

namespace {

/// The last reachable point on the line from the workspace's centre to `wanted_m`.
Vector3 nearest_in_reach(const device::PhantomGeometry &geometry, const Vector3 &centre_m,
                         const Vector3 &wanted_m) {
    if (device::joint_angles_rad(geometry, wanted_m)) {
        return wanted_m;
    }
    const Vector3 offset_m = wanted_m - centre_m;
    const auto is_in_reach = [&](double share) {
        return device::joint_angles_rad(geometry, centre_m + share * offset_m).has_value();
    };
    return centre_m + bisect({0.0, 1.0}, 20, is_in_reach).holds_at * offset_m;
}

} // namespace

void SimulatedHand::take_hold(simulated::HandControl *hand, const device::DeviceDescription &device,
                              const std::optional<simulated::HandPath> &path,
                              const Vector3 &target_m) {
    hand_ = hand;
    geometry_ = device.geometry;
    workspace_ = device.workspace;
    path_ = path;
    path_began_s_ = 0.0;
    target_m_ = target_m;
}

void SimulatedHand::move_to(const Vector3 &target_m) {
    const Vector3 lower_m = workspace_.centre_m - 0.5 * workspace_.size_m;
    const Vector3 upper_m = workspace_.centre_m + 0.5 * workspace_.size_m;
    target_m_ = nearest_in_reach(geometry_, workspace_.centre_m,
                                 target_m.cwiseMax(lower_m).cwiseMin(upper_m));
    if (hand_ != nullptr) {
        hand_->set_hand_target(target_m_);
    }
}

void SimulatedHand::play(simulated::HandStimulus stimulus) {
    stimulus.number = ++stimuli_;
    if (hand_ != nullptr) {
        hand_->play(stimulus);
    }
}

void SimulatedHand::follow(const simulated::HandPath &path, double began_s) {
    path_ = path;
    path_began_s_ = began_s;
}

void SimulatedHand::advance(double time_s) {
    if (path_) {
        target_m_ = path_->at(time_s - path_began_s_).position_m;
        if (time_s - path_began_s_ > path_->end_s()) {
            path_.reset();
        }
    }
}

} // namespace springdrive::session

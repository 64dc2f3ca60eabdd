// The hand of a simulated world: where it wants to be, by a path or as it is asked.
#pragma once

#include "device/core/device_file.h"
#include "device/simulated/hand_path.h"
#include "device/simulated/simulated_world.h"

#include <optional>

namespace springdrive::session {

class GuidedHand {
public:
    /// Takes hold of a device's tip, which is at the path's start, or else at `target_m`.
    /// @param world  null where the hand is a person's: it is where it is then. Must outlive it.
    void take_hold(simulated::SimulatedWorld *world, const device::DeviceDescription &device,
                   const std::optional<simulated::HandPath> &path, const Vector3 &target_m);

    /// As far as workspace and reach allow; without effect on a hand that follows a path.
    void move_to(const Vector3 &target_m);

    /// Where its path has it at that time of the servo.
    void follow(double time_s);

    [[nodiscard]] const Vector3 &target_m() const { return target_m_; }
    [[nodiscard]] bool follows_path() const { return path_.has_value(); }

private:
    simulated::SimulatedWorld *world_ = nullptr;
    device::PhantomGeometry geometry_;
    device::Workspace workspace_;
    std::optional<simulated::HandPath> path_;
    Vector3 target_m_{Vector3::Zero()};
};

} // namespace springdrive::session

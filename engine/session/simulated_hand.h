// The hand that holds a simulated or emulated device: its target, by a path or by request.
#pragma once

#include "device/core/device_description.h"
#include "device/simulated/hand_control.h"
#include "device/simulated/hand_path.h"

#include <cstdint>
#include <optional>

namespace springdrive::session {

class SimulatedHand {
public:
    /// Attaches the hand to a device's tip, which is at the path's start, or else at `target_m`.
    /// @param hand  must outlive this object; null for a real hand, which cannot be moved
    void take_hold(simulated::HandControl *hand, const device::DeviceDescription &device,
                   const std::optional<simulated::HandPath> &path, const Vector3 &target_m);

    /// Sets the target, limited to workspace and reach; takes effect once the path has ended.
    void move_to(const Vector3 &target_m);

    /// Starts a test signal beside the target; needs a simulated hand.
    void play(simulated::HandStimulus stimulus);
    [[nodiscard]] bool is_simulated() const { return hand_ != nullptr; }

    /// Notes that the device's hand follows this path, which began at this servo time.
    void follow(const simulated::HandPath &path, double began_s);

    /// Sets the target to that of the path at this servo time, up to the path's end: from then on
    /// the hand holds still until it is moved.
    void advance(double time_s);

    [[nodiscard]] const Vector3 &target_m() const { return target_m_; }
    [[nodiscard]] bool follows_path() const { return path_.has_value(); }

private:
    simulated::HandControl *hand_ = nullptr;
    device::PhantomGeometry geometry_;
    device::Workspace workspace_;
    std::optional<simulated::HandPath> path_;
    double path_began_s_ = 0.0;
    Vector3 target_m_{Vector3::Zero()};
    std::uint32_t stimuli_ = 0; ///< played so far
};

} // namespace springdrive::session

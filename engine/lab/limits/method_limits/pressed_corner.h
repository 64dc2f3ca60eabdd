// What the experiments on the servo run: a servo in a corner, and ticks that are late.
#pragma once

#include "engine/lab/loops/stability_case.h"
#include "engine/lab/rig/servo_rig.h"

namespace springdrive::limits {

/// A servo on a simulated device with its tip in a corner of three walls, which holds it at a
/// point, or in free space near it.
class PressedCorner : public rig::ServoRig {
public:
    /// Starts the servo, with the tip at rest in free space near the corner.
    /// @param which  device, tuning, period, delay and configuration; hands[0] holds
    /// @param hand_force_N  the maximum force with which it presses
    explicit PressedCorner(const loops::StabilityCase &which, double hand_force_N = 20.0);

    /// Runs until the tip rests in the corner, pressed against all three walls.
    /// @param force_N  by which the hand's spring is stretched
    void press(double force_N);
    /// Shifts the hand's target by 0.1 mm from the next tick on.
    void nudge();

private:
    PressedCorner(const loops::StabilityCase &which, const rig::Scenario &scenario);

    double hand_N_per_m_;
    Vector3 corner_m_;
    Vector3 target_m_;
};

/// The largest |eigenvalue| over two ticks of a servo with every other tick late.
///
///   tick                        tick, late by k T      tick
///    A ─────── A's, (1 + k) T ───── B ── B's, T ──────── A
///
/// The amplifiers hold a tick's command until the next one, which takes the time since then
/// as (1 + k) T.
/// @pre law or hand pull on every position; no other delay
[[nodiscard]] double late_ticks_eigenvalue(const loops::StabilityCase &which,
                                           const loops::LoopMember &member, int missed);

} // namespace springdrive::limits

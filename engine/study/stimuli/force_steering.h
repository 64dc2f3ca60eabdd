// Keeps a contact's force in a direction that is not that of its spring.
//
// The spring of a contact pulls the tip towards x₀. A force that is turned is that of a spring
// whose x₀ moves: by s along the surface it adds K s, whatever the tip does. If s were a function
// of the tip's position, s = δ tan φ with δ the indentation, the stiffness would be turned, and a
// turned stiffness is no spring: its curl, K tan φ, is work for whoever moves the tip round in a
// circle. So s is a function of time. It follows the direction wanted as an integral does,
//
//   df/dt = (F_n t_s/t_n − F_s)/τ        f = K s, along the surface
//
// with F_n and F_s the rendered force along the normal and the surface, as the currents tell it,
// and t the direction. At rest F is in the direction t whatever the hand's stiffness is, whatever
// the tip has yielded along the surface, and whatever dR really is. A hand of stiffness k yields
// along the surface until F_s = k y, so f is there with the time constant τ (K + k)/k: 53 ms for a
// relaxed grip of 300 N/m at 1700 N/m. To a hand that moves faster it is a spring with a constant
// force; slower, the surface yields like one without friction, square to t.
//
// What slow circles can still earn is bounded: the work that the force along the surface does on
// the hand is counted, and beyond `max_work_J` the steering gives up: it then keeps the force
// along the normal.
//
// A blow is over before that. There f is F_n t_s/t_n at once, with the integral of what is left:
// the turned stiffness itself, under the same bound.
#pragma once

#include "base/vector.h"

#include <cstdint>

namespace springdrive::study {

class ForceSteering {
public:
    static constexpr double kTime_s = 0.008; ///< τ

    enum class Pace : std::uint8_t { slow, prompt };

    /// @param normal     unit
    /// @param direction  unit; less than 90° from the normal
    ForceSteering(const Vector3 &normal, const Vector3 &direction, Pace pace, double max_work_J,
                  double max_force_N, double period_s);

    /// Advances by one tick; the force that is to be added, along the surface [N]. RT-safe.
    /// @param force_N  the rendered one
    /// @param share    of the turn's tangent, 0 to 1: 0 is a force along the normal
    Vector3 update(const Vector3 &tip_m, const Vector3 &force_N, double share) noexcept;

    /// Work of the rendered force along the surface on the hand so far [J].
    [[nodiscard]] double work_J() const { return work_J_; }
    [[nodiscard]] bool has_given_up() const { return has_given_up_; }

private:
    void count(const Vector3 &tip_m, const Vector3 &force_N) noexcept;

    Vector3 normal_;
    Vector3 slope_; ///< t_s/t_n
    bool is_prompt_;
    double max_work_J_;
    double max_force_N_;
    double gap_share_; ///< that is closed in a tick
    Vector3 integral_N_{Vector3::Zero()};
    Vector3 last_tip_m_{Vector3::Zero()};
    Vector3 last_force_N_{Vector3::Zero()};
    bool has_last_ = false;
    bool has_given_up_ = false;
    double work_J_ = 0.0;
};

} // namespace springdrive::study

// First-order filter on the differentiated motor angles (docs/design.md, "Sampled forms"):
//
//   v[k] = a v[k−1] + (1 − a)(θ[k] − θ[k−1])/T,   a = e^(−λT)
#pragma once

#include "base/vector.h"

#include <cmath>

namespace springdrive::control {

/// a = e^(−λT), the filter's pole.
[[nodiscard]] inline double velocity_filter_pole(double lambda_rad_per_s, double period_s) {
    return std::exp(-lambda_rad_per_s * period_s);
}

class VelocityFilter {
public:
    VelocityFilter() = default;

    /// Continues from these angles with this filtered velocity.
    VelocityFilter(const Vector3 &theta_rad, const Vector3 &velocity_rad_per_s)
        : theta_rad_(theta_rad), velocity_rad_per_s_(velocity_rad_per_s) {}

    [[nodiscard]] const Vector3 &theta_rad() const { return theta_rad_; }
    [[nodiscard]] const Vector3 &velocity_rad_per_s() const { return velocity_rad_per_s_; }

    /// Restarts at rest.
    void reset(const Vector3 &theta_rad) noexcept {
        theta_rad_ = theta_rad;
        velocity_rad_per_s_.setZero();
    }

    /// θ̇_f [rad/s] after the newest angles. RT-safe.
    Vector3 update(const Vector3 &theta_rad, double pole, double period_s) noexcept {
        velocity_rad_per_s_ =
            pole * velocity_rad_per_s_ + (1.0 - pole) / period_s * (theta_rad - theta_rad_);
        theta_rad_ = theta_rad;
        return velocity_rad_per_s_;
    }

private:
    Vector3 theta_rad_{Vector3::Zero()};
    Vector3 velocity_rad_per_s_{Vector3::Zero()};
};

} // namespace springdrive::control

// Tells from angles alone whether a motion has come down to the flicker of an encoder's last
// digits, however fast: not a motion that a loop makes.
#pragma once

#include "base/vector.h"

#include <cmath>

namespace springdrive::rig {

class Flicker {
public:
    /// @param most_rad  how far the angles may go to and fro
    /// @param lasting_s  for how long they must not have gone farther
    Flicker(double most_rad, double lasting_s, double period_s)
        : most_rad_(most_rad), lasting_(std::ceil(lasting_s / period_s)) {}

    /// Takes in the next sample's angles. Where they went too far, the count begins anew.
    void watch(const Vector3 &angles_rad) {
        least_rad_ = least_rad_.cwiseMin(angles_rad);
        greatest_rad_ = greatest_rad_.cwiseMax(angles_rad);
        samples_ += 1.0;
        began_anew_ =
            !angles_rad.allFinite() || !((greatest_rad_ - least_rad_).maxCoeff() <= most_rad_);
        if (began_anew_) {
            least_rad_ = greatest_rad_ = angles_rad;
            samples_ = 1.0;
        }
    }

    /// Whether there was no more than a flicker for long enough.
    [[nodiscard]] bool is_all() const { return samples_ >= lasting_; }

    /// Whether it looks like one, for however short a time.
    [[nodiscard]] bool may_be_all() const { return !began_anew_; }

private:
    double most_rad_;
    double lasting_; ///< samples
    Vector3 least_rad_{Vector3::Constant(HUGE_VAL)};
    Vector3 greatest_rad_{Vector3::Constant(-HUGE_VAL)};
    double samples_ = 0.0; ///< in a row
    bool began_anew_ = false;
};

} // namespace springdrive::rig

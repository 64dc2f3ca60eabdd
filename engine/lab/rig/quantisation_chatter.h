// Detects from angles alone whether a motion has decayed to chatter within the last counts of an
// encoder, however fast: a limit cycle of quantisation, not an instability of the loop.
#pragma once

#include "base/vector.h"

#include <cmath>

namespace springdrive::rig {

class QuantisationChatter {
public:
    /// @param most_rad  the largest peak-to-peak amplitude
    /// @param lasting_s  for how long it must not have been exceeded
    QuantisationChatter(double most_rad, double lasting_s, double period_s)
        : most_rad_(most_rad), lasting_(std::ceil(lasting_s / period_s)) {}

    /// Adds the next sample's angles. Where they exceed the amplitude, the count restarts.
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

    /// Whether there was only chatter for long enough.
    [[nodiscard]] bool is_all() const { return samples_ >= lasting_; }

    /// Whether there is only chatter now, for however short a time.
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

// Detects from angles alone whether a motion has decayed to chatter within the last counts of an
// encoder, however fast: a limit cycle of quantisation, not an instability of the loop.
#pragma once

#include "base/vector.h"

#include <cmath>

namespace springdrive::rig {

class QuantisationChatter {
public:
    /// @param max_range_rad  the largest peak-to-peak amplitude
    /// @param lasting_s  for how long it must not have been exceeded
    QuantisationChatter(double max_range_rad, double lasting_s, double period_s)
        : max_range_rad_(max_range_rad), lasting_(std::ceil(lasting_s / period_s)) {}

    /// Adds the next sample's angles. Where they exceed the amplitude, the count restarts.
    void watch(const Vector3 &angles_rad) {
        min_rad_ = min_rad_.cwiseMin(angles_rad);
        max_rad_ = max_rad_.cwiseMax(angles_rad);
        samples_ += 1.0;
        began_anew_ =
            !angles_rad.allFinite() || !((max_rad_ - min_rad_).maxCoeff() <= max_range_rad_);
        if (began_anew_) {
            min_rad_ = max_rad_ = angles_rad;
            samples_ = 1.0;
        }
    }

    /// Whether there was only chatter for long enough.
    [[nodiscard]] bool is_all() const { return samples_ >= lasting_; }

    /// Whether there is only chatter now, for however short a time.
    [[nodiscard]] bool may_be_all() const { return !began_anew_; }

private:
    double max_range_rad_;
    double lasting_; ///< samples
    Vector3 min_rad_{Vector3::Constant(HUGE_VAL)};
    Vector3 max_rad_{Vector3::Constant(-HUGE_VAL)};
    double samples_ = 0.0; ///< in a row
    bool began_anew_ = false;
};

} // namespace springdrive::rig

// A change of tuning, map or scene in contact is not to be felt as a blow: whatever it makes of e_W
// at once is carried along, and let go of at a bounded rate.
//
//   e_W = law(after the change) + carried,    carried := law(before) − law(after), on to zero
//
// So no change by itself moves e_W by more than kGreatestChange_V_per_s · T in a tick.
#pragma once

#include "base/vector.h"

namespace springdrive::servo {

/// 0.05 V in a tick of a millisecond: at a dR of 0.5 Ω some 0.2 N at the tip.
inline constexpr double kGreatestChange_V_per_s = 50.0;

class ChangeOver {
public:
    explicit ChangeOver(double period_s) { set_period(period_s); }

    /// RT-safe.
    void set_period(double period_s) noexcept { bound_V_ = kGreatestChange_V_per_s * period_s; }

    /// On the state of one tick e_W was `before_V`, and is `after_V` by a change alone. RT-safe.
    void change(const Vector3 &before_V, const Vector3 &after_V) noexcept {
        carried_V_ += before_V - after_V;
    }

    /// One tick on: lets go of as much as may be. RT-safe.
    void fade() noexcept { carried_V_ -= carried_V_.cwiseMax(-bound_V_).cwiseMin(bound_V_); }

    void reset() noexcept { carried_V_.setZero(); }

    [[nodiscard]] const Vector3 &carried_V() const { return carried_V_; }

private:
    double bound_V_ = 0.0;
    Vector3 carried_V_{Vector3::Zero()};
};

} // namespace springdrive::servo

// A change of tuning, map or scene in contact is not to be felt as a blow. Parameters glide to what
// is asked for; whatever a change makes of e_W at once is carried along, and let go of at a bounded
// rate:
//
//   e_W = law(after the change) + carried,    carried := law(before) − law(after), on to zero
//
// So no change by itself moves e_W by more than kGreatestChange_V_per_s · T in a tick.
#pragma once

#include "base/vector.h"
#include "device/core/device_file.h"
#include "engine/control/tuning.h"

#include <optional>

namespace springdrive::servo {

/// 0.05 V in a tick of a millisecond: at a dR of 0.5 Ω some 0.2 N at the tip.
inline constexpr double kGreatestChange_V_per_s = 50.0;

/// All that the law is set to.
struct LawSettings {
    control::Tuning tuning;
    double global_alpha_rad2_per_m2 = 0.0;

    bool operator==(const LawSettings &) const = default;
};

class BumplessTransfer {
public:
    BumplessTransfer(const device::DeviceDescription &device, double period_s);

    void set_period(double period_s) noexcept;

    /// One tick on towards the settings wanted.
    /// @param is_felt  whether what the law says reaches the motors; else nothing has to glide
    void approach(const LawSettings &wanted, bool is_felt) noexcept;

    [[nodiscard]] const LawSettings &active() const { return active_; }
    /// Those of the tick before.
    [[nodiscard]] const LawSettings &before() const { return before_; }
    [[nodiscard]] bool has_changed() const { return !(active_ == before_); }

    /// What e_W is to be where the law says `e_W_V`: this tick's changes are carried over.
    /// @param unchanged_V  what the law says on the same state under the settings before, if those
    ///                     have changed
    /// @param scene_is_new  the old one's contact is not known any more: what was last asked for is
    [[nodiscard]] Vector3 transferred_V(const Vector3 &e_W_V,
                                        const std::optional<Vector3> &unchanged_V,
                                        bool scene_is_new, bool is_felt) noexcept;

    /// What e_W is off what the law says.
    [[nodiscard]] const Vector3 &carried_V() const { return carried_V_; }

private:
    [[nodiscard]] Vector3 within_supply(const Vector3 &e_W_V) const noexcept;

    Vector3 supply_V_;
    double peak_current_A_; ///< the greatest of the motors
    double period_s_;
    LawSettings active_;
    LawSettings before_;
    Vector3 carried_V_{Vector3::Zero()};
    Vector3 last_e_W_V_{Vector3::Zero()}; ///< as transferred, within the supply
};

} // namespace springdrive::servo

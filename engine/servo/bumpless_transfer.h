// Bumpless transfer: a change of tuning, map or scene in contact must not cause a force step.
// Parameters approach their new values smoothly; the step that a change would cause in e_W is
// compensated by an offset, which decays at a bounded rate:
//
//   e_W = law(after the change) + carried,    carried := law(before) − law(after), then to zero
//
// So no change alone moves e_W by more than kMaxChange_V_per_s · T per tick.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"
#include "engine/control/tuning.h"

#include <optional>

namespace springdrive::servo {

/// 0.05 V per tick of 1 ms: about 0.2 N at the tip at a dR of 0.5 Ω.
inline constexpr double kMaxChange_V_per_s = 50.0;

/// How fast R̂ may change [Ω/s]: R̂ i is a voltage, too, and even at the largest peak current changes
/// no faster than kMaxChange_V_per_s.
[[nodiscard]] double max_resistance_change_Ohm_per_s(const device::DeviceDescription &device);

/// All settings of the control law.
struct LawSettings {
    control::Tuning tuning;
    double global_alpha_rad2_per_m2 = 0.0;

    bool operator==(const LawSettings &) const = default;
};

class BumplessTransfer {
public:
    BumplessTransfer(const device::DeviceDescription &device, double period_s);

    void set_period(double period_s) noexcept;

    /// Advances by one tick towards the requested settings.
    /// @param is_felt  whether the law's command reaches the motors; otherwise settings change
    ///                 immediately
    void approach(const LawSettings &requested, bool is_felt) noexcept;

    [[nodiscard]] const LawSettings &active() const { return active_; }
    /// The settings of the previous tick.
    [[nodiscard]] const LawSettings &before() const { return before_; }
    [[nodiscard]] bool has_changed() const { return !(active_ == before_); }

    /// Sets the offset for which `e_W_V` of the law makes no step by this tick's changes.
    /// @param unchanged_V  the law's e_W for the same state with the previous settings, if they
    ///                     have changed
    /// @param scene_is_new  the old scene's contact is unknown, so the last e_W is continued
    void carry(const Vector3 &e_W_V, const std::optional<Vector3> &unchanged_V, bool scene_is_new,
               bool is_felt) noexcept;

    /// The offset of e_W from the law's value.
    [[nodiscard]] const Vector3 &transfer_offset_V() const { return transfer_offset_V_; }

private:
    [[nodiscard]] Vector3 within_supply(const Vector3 &e_W_V) const noexcept;

    Vector3 supply_V_;
    double max_dR_change_Ohm_per_s_;
    double period_s_;
    LawSettings active_;
    LawSettings before_;
    Vector3 transfer_offset_V_{Vector3::Zero()};
    Vector3 last_e_W_V_{Vector3::Zero()}; ///< including the offset, within the supply
};

} // namespace springdrive::servo

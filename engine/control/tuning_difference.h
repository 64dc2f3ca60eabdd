// What differs between two tunings, for people; and a preset applied to the active tuning.
#pragma once

#include "engine/control/tuning.h"

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::control {

/// A parameter, the map or the source of α, before and after.
struct TuningChange {
    std::string_view name;   ///< of the parameter, or "map", "alpha_mode": as in files
    std::string_view symbol; ///< for people, UTF-8
    std::string before;
    std::string after;
    std::string_view unit; ///< UTF-8; empty where it has none
};

/// All that differs, in the order of `kParameters`, then the map and the source of α. α is left out
/// where it acts in neither tuning. Numbers have three significant digits and all digits before the
/// point, and more where `before` and `after` would otherwise look the same.
[[nodiscard]] std::vector<TuningChange> changes_between(const Tuning &before, const Tuning &after);

/// In one line: "dR 0.5 → 0.3 Ω, map inverse (18) → transpose (23)"; "no difference" when empty.
[[nodiscard]] std::string text_of(const std::vector<TuningChange> &changes);

/// What a preset sets: the gains of the loop. Map, source of α, α and η say how and how much of the
/// stiffness is used; they are the user's choice for a scene or an experiment, and remain.
inline constexpr std::array kGainsOfPresets{&Tuning::dR_Ohm, &Tuning::K_P_V_per_rad,
                                            &Tuning::K_D_Vs_per_rad, &Tuning::lambda_rad_per_s};

/// The active tuning with the gains of a preset. It equals `active` if these are active already.
[[nodiscard]] Tuning with_gains_of(const Tuning &active, const Tuning &preset);

} // namespace springdrive::control

// The live tuning, and the one list of its parameters: panels, command line, tuning files, CSV
// headers and documentation all read it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::control {

/// How a set-point of the tip becomes one of the motors.
enum class MotionMap : std::uint8_t {
    inverse,   ///< (18): stiffest in every direction, but an ellipsoid
    transpose, ///< (23), (24): a sphere, scaled by α
};

/// The source of α in (23).
enum class AlphaMode : std::uint8_t {
    on_the_fly, ///< the bound (29) at the present configuration
    global,     ///< the minimum of (29) over the workspace
    by_hand,    ///< Tuning::alpha_rad2_per_m2
    at_touch,   ///< (29) where a contact began, then only ever less: gives no energy
};

/// The defaults are the tuning `firm`.
struct Tuning {
    double dR_Ohm = 0.5;               ///< dR (7); the amplifier cancels R̂ = R − dR
    double K_P_V_per_rad = 6.0;        ///< K_P of (10)
    double K_D_Vs_per_rad = 0.01;      ///< K_D of (10)
    double lambda_rad_per_s = 1000.0;  ///< λ, cutoff of the velocity filter
    double alpha_rad2_per_m2 = 3000.0; ///< α of (23), used when `alpha_mode` is by_hand
    double eta = 0.0;                  ///< η of (30), in addition to the surface's own
    MotionMap map = MotionMap::transpose;
    AlphaMode alpha_mode = AlphaMode::on_the_fly;

    friend bool operator==(const Tuning &, const Tuning &) = default;
};

struct Parameter {
    std::string_view name;   ///< in files and CSV headers, with its unit
    std::string_view option; ///< on the command line, without dashes
    std::string_view symbol; ///< in panels, UTF-8
    std::string_view unit;   ///< in panels, UTF-8; "–" where it has none
    double Tuning::*value = nullptr;
    double minimum = 0.0;      ///< inclusive
    double maximum = 0.0;      ///< inclusive
    bool logarithmic = false;  ///< how a slider should run, down to 0 where that is the minimum
    std::string_view equation; ///< where the paper brings it in
    std::string_view help;

    [[nodiscard]] double default_value() const { return Tuning{}.*value; }
};

/// K_P and K_D reach as far as the limits found by `stability --vary`, the map in the stability tab
/// and the stiffest tunings with their margin: at 10 kHz and dR 0.5 Ω K_P 199 V/rad, and 258 with
/// the margin.
inline constexpr std::array<Parameter, 6> kParameters{{
    {"dR_Ohm", "dR", "dR", "Ω", &Tuning::dR_Ohm, 0.02, 2.18, true, "(7)",
     "residual winding resistance: lower is stiffer in contact with the same K_P, and heavier "
     "in free space"},
    {"K_P_V_per_rad", "kp", "K_P", "V/rad", &Tuning::K_P_V_per_rad, 0.0, 500.0, true, "(10)",
     "position gain of the drift compensation: sets the static stiffness k_T K_P/dR"},
    {"K_D_Vs_per_rad", "kd", "K_D", "V·s/rad", &Tuning::K_D_Vs_per_rad, 0.0, 1.0, true, "(10)",
     "velocity gain of the drift compensation: stiffness at middle frequencies"},
    {"lambda_rad_per_s", "lambda", "λ", "rad/s", &Tuning::lambda_rad_per_s, 100.0, 5000.0, true,
     "(12)", "cutoff of the velocity filter: higher is lighter in free space and noisier"},
    {"alpha_rad2_per_m2", "alpha", "α", "rad²/m²", &Tuning::alpha_rad2_per_m2, 0.0, 20000.0, false,
     "(23)",
     "scale of the transpose map when set by hand; above the bound (29) a motor's gains exceed "
     "its tuning"},
    {"eta", "eta", "η", "–", &Tuning::eta, 0.0, 1.0, false, "(30)",
     "0 rigid, 1 free space: the stiffness is scaled by 1 − η on top of the surface's own η"},
}};

/// The row of a member of `Tuning`.
[[nodiscard]] constexpr const Parameter &parameter_of(double Tuning::*value) {
    return *std::ranges::find(kParameters, value, &Parameter::value);
}

/// False for a NaN too. RT-safe.
[[nodiscard]] bool lies_in_range(const Parameter &parameter, const Tuning &tuning) noexcept;

/// Why `tuning` cannot be used: the first parameter out of its range or not finite, with the
/// range; empty when it can.
[[nodiscard]] std::string validate(const Tuning &tuning);

/// The same question without the words. RT-safe.
[[nodiscard]] bool is_valid(const Tuning &tuning) noexcept;

/// The names of the maps and of the sources of α in files, records and on the command line, by
/// their number.
inline constexpr std::array<std::string_view, 2> kMotionMapNames{"inverse", "transpose"};
inline constexpr std::array<std::string_view, 4> kAlphaModeNames{"on_the_fly", "global", "by_hand",
                                                                 "at_touch"};

[[nodiscard]] constexpr std::string_view name_of(MotionMap map) {
    return kMotionMapNames[static_cast<std::size_t>(map)];
}
[[nodiscard]] constexpr std::string_view name_of(AlphaMode mode) {
    return kAlphaModeNames[static_cast<std::size_t>(mode)];
}

/// What they are called for people, by their number.
inline constexpr std::array<const char *, 2> kMotionMapLabels{"inverse (18)", "transpose (23)"};
inline constexpr std::array<const char *, 4> kAlphaModeLabels{"α on the fly", "global α",
                                                              "α by hand", "α at touch"};
static_assert(kMotionMapLabels.size() == kMotionMapNames.size());
static_assert(kAlphaModeLabels.size() == kAlphaModeNames.size());

[[nodiscard]] constexpr std::string_view label_of(MotionMap map) {
    return kMotionMapLabels[static_cast<std::size_t>(map)];
}
[[nodiscard]] constexpr std::string_view label_of(AlphaMode mode) {
    return kAlphaModeLabels[static_cast<std::size_t>(mode)];
}

/// One of `kMotionMapNames`; nothing for any other name.
[[nodiscard]] std::optional<MotionMap> motion_map_named(std::string_view name);

/// One of `kAlphaModeNames`; nothing for any other name.
[[nodiscard]] std::optional<AlphaMode> alpha_mode_named(std::string_view name);

// What differs between two tunings, for people; and a preset applied to the active tuning.

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

// The live tuning: the six parameters, and the maps through which they act.
#pragma once

#include <cstdint>

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

} // namespace springdrive::control

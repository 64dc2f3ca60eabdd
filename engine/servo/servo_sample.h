// Telemetry: everything one servo tick knew and did, in one sample with one timestamp.
#pragma once

#include "base/vector.h"
#include "engine/contact/contact.h"
#include "engine/control/tuning.h"
#include "engine/servo/safety_monitor.h"

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

namespace springdrive {

struct ServoSample {
    std::uint64_t tick = 0;
    double time_s = 0.0; ///< tick × T
    std::array<std::int32_t, 3> counts{};
    Vector3 theta_rad{Vector3::Zero()};            ///< θ, from the counts
    Vector3 theta_rate_rad_per_s{Vector3::Zero()}; ///< θ̇_f
    Vector3 tip_m{Vector3::Zero()};                ///< x
    Contact contact;                               ///< x₀, P, n, the surface's η
    double eta = 1.0;                              ///< η in force, surface and tuning together
    double alpha_rad2_per_m2 = 0.0;                ///< α in force
    double alpha_bound_rad2_per_m2 = 0.0;          ///< (29) at this configuration
    Vector3 x_Sd_m{Vector3::Zero()};
    Vector3 theta_Sd_rad{Vector3::Zero()}; ///< of the map in use
    DeviceCommand command;                 ///< as passed on by the safety monitor
    Vector3 current_A{Vector3::Zero()};
    Vector3 tip_force_N{Vector3::Zero()}; ///< rendered: J⁻ᵀ k_T i (3), (22)
    double rendered_error_rad = 0.0;      ///< angle of `tip_force_N` to n; NaN when free
    double inverse_error_rad = 0.0;       ///< the same for the static force of (18), on this state
    double transpose_error_rad = 0.0;     ///< and for that of (23)
    MotionMap map = MotionMap::transpose;
    bool inverse_possible = true; ///< false: out of reach or singular, (18) has no answer
    SafetyStatus safety;
    std::array<WindingStatus, 3> winding{}; ///< as the safety monitor has it, per motor
    std::uint32_t scene_id = 0;
    // Measured by the clock; NaN in lockstep, where there is none.
    double period_s = std::numeric_limits<double>::quiet_NaN();   ///< since the last tick began
    double compute_s = std::numeric_limits<double>::quiet_NaN();  ///< from answer to command
    double exchange_s = std::numeric_limits<double>::quiet_NaN(); ///< what the device took
};

/// The columns of a telemetry CSV, one name for each number of a row.
[[nodiscard]] std::string telemetry_header();

/// One line without its end; NaN is written as an empty cell.
[[nodiscard]] std::string telemetry_row(const ServoSample &sample);

} // namespace springdrive

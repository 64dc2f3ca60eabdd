// Telemetry: everything one servo tick knew and did, in one sample with one timestamp.
#pragma once

#include "base/vector.h"
#include "device/core/haptic_device.h"
#include "engine/contact/contact.h"
#include "engine/control/tuning.h"
#include "engine/servo/safety_limits.h"
#include "engine/servo/safety_status.h"

#include <array>
#include <cstdint>
#include <limits>

namespace springdrive::servo {

struct ServoSample {
    std::uint64_t tick = 0;
    double time_s = 0.0; ///< of the servo: T more each tick
    std::uint64_t measurement_number = 0;
    double measured_s = 0.0; ///< when, by the device's clock
    device::Arrival arrival = device::Arrival::fresh;
    device::DeviceHealth health = device::DeviceHealth::ok;
    std::uint16_t board_faults = 0; ///< see BoardFaults
    double supply_V = std::numeric_limits<double>::quiet_NaN();
    double since_last_s = 0.0; ///< from the measurement before; 0 where nothing new was measured
    std::array<std::int32_t, 3> counts{};
    Vector3 theta_rad{Vector3::Zero()};            ///< θ, from the counts
    Vector3 theta_rate_rad_per_s{Vector3::Zero()}; ///< θ̇_f
    Vector3 tip_m{Vector3::Zero()};                ///< x
    contact::Contact contact;                      ///< x₀, P, n, the surface's η
    std::uint32_t scene_id = 0;
    control::Tuning tuning;                ///< in force
    double eta = 1.0;                      ///< η in force, surface and tuning together
    double global_alpha_rad2_per_m2 = 0.0; ///< what AlphaMode::global takes
    double alpha_rad2_per_m2 = 0.0;        ///< α in force
    double alpha_bound_rad2_per_m2 = 0.0;  ///< (29) at this configuration
    Vector3 x_Sd_m{Vector3::Zero()};
    Vector3 theta_Sd_rad{Vector3::Zero()}; ///< of the map in use
    bool inverse_possible = true;          ///< false: out of reach or singular, (18) has no answer
    Vector3 carried_V{Vector3::Zero()}; ///< of e_W: what a change has not been let through of yet
    device::DeviceCommand command;      ///< as passed on by the safety monitor
    Vector3 current_A{Vector3::Zero()};
    Vector3 tip_force_N{Vector3::Zero()}; ///< rendered: J⁻ᵀ k_T i (3), (22)
    double rendered_error_rad = 0.0;      ///< angle of `tip_force_N` to n; NaN when free
    double inverse_error_rad = 0.0;       ///< the same for the static force of (18), on this state
    double transpose_error_rad = 0.0;     ///< and for that of (23)
    SafetyStatus safety;
    ActiveLimits held_back;
    SafetyLimits limits;                    ///< in force
    double generated_energy_J = 0.0;        ///< as the energy observer has it
    std::array<WindingStatus, 3> winding{}; ///< as the safety monitor has it, per motor
    std::uint32_t missed_deadlines = 0;     ///< of the host, passed over before this tick
    std::uint32_t missed_in_a_row = 0;      ///< with those before the late ticks just before
    std::uint32_t missed_periods = 0; ///< of the device, in which it was not measured for a tick
    // Measured by the clock; NaN in lockstep, where there is none.
    double clock_s = std::numeric_limits<double>::quiet_NaN();    ///< start, since the servo's own
    double lateness_s = std::numeric_limits<double>::quiet_NaN(); ///< from deadline to start
    double period_s = std::numeric_limits<double>::quiet_NaN();   ///< since the last tick began
    double read_s = std::numeric_limits<double>::quiet_NaN();     ///< what the device took to read
    double compute_s = std::numeric_limits<double>::quiet_NaN();  ///< from measurement to command
    double write_s = std::numeric_limits<double>::quiet_NaN();    ///< and what it took to write
};

} // namespace springdrive::servo

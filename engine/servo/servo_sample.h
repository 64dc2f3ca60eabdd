// Telemetry: all inputs and results of one servo tick, in one sample with one timestamp.
#pragma once

#include "base/vector.h"
#include "device/core/haptic_device.h"
#include "engine/contact/contact.h"
#include "engine/control/haptic_law.h"
#include "engine/control/tuning.h"
#include "engine/control/winding_observer.h"
#include "engine/servo/safety_limits.h"
#include "engine/servo/safety_status.h"

#include <array>
#include <cstdint>
#include <limits>

namespace springdrive::servo {

struct ServoSample {
    std::uint64_t tick = 0;
    double time_s = 0.0; ///< servo time: increases by T each tick
    std::uint64_t measurement_number = 0;
    double measured_s = 0.0; ///< time of the measurement, by the device's clock
    device::Arrival arrival = device::Arrival::fresh;
    device::DeviceHealth health = device::DeviceHealth::ok;
    std::uint16_t board_faults = 0; ///< see BoardFaults
    double supply_V = std::numeric_limits<double>::quiet_NaN();
    double since_last_s = 0.0; ///< since the previous measurement; 0 without a new one
    std::array<std::int32_t, 3> counts{};
    Vector3 theta_rad{Vector3::Zero()};            ///< θ, from the counts
    Vector3 theta_rate_rad_per_s{Vector3::Zero()}; ///< θ̇_f
    Vector3 tip_m{Vector3::Zero()};                ///< x
    contact::Contact contact;                      ///< x₀, P, n, the surface's η
    std::uint32_t scene_id = 0;
    control::Tuning tuning;                ///< active
    double eta = 1.0;                      ///< active η, of surface and tuning together
    double global_alpha_rad2_per_m2 = 0.0; ///< for AlphaMode::global
    double alpha_rad2_per_m2 = 0.0;        ///< active α
    double alpha_bound_rad2_per_m2 = 0.0;  ///< (29) at this configuration
    Vector3 x_Sd_m{Vector3::Zero()};
    Vector3 theta_Sd_rad{Vector3::Zero()};      ///< of the map in use
    bool inverse_possible = true;               ///< false: out of reach or singular for (18)
    Vector3 transfer_offset_V{Vector3::Zero()}; ///< offset of e_W: bumpless transfer and excitation
    control::ObservedMotors motor;              ///< for which the command was computed
    double lag_s = 0.0;                         ///< T (½ + d), with which it was computed
    Vector3 dR_Ohm{Vector3::Zero()};            ///< at which each motor is driven
    Vector3 stiffness_share{Vector3::Ones()};   ///< of the tuning's K_q (20), see drive_gains.h
    device::DeviceCommand command;              ///< as passed on by the safety monitor
    Vector3 current_A{Vector3::Zero()};         ///< as measured, with the sensors' offsets
    Vector3 tip_force_N{Vector3::Zero()};       ///< rendered force: J⁻ᵀ k_T i (3), (22)
    double rendered_error_rad = 0.0;  ///< angle between `tip_force_N` and n; NaN when free
    double inverse_error_rad = 0.0;   ///< the same for the static force of (18) in this state
    double transpose_error_rad = 0.0; ///< the same for that of (23)
    SafetyStatus safety;
    ActiveLimits active_limits;
    SafetyLimits limits;                    ///< active
    double generated_energy_J = 0.0;        ///< by the energy observer
    std::array<WindingStatus, 3> winding{}; ///< by the safety monitor, per motor
    std::uint32_t missed_deadlines = 0;     ///< of the host, skipped before this tick
    std::uint32_t missed_in_a_row = 0;      ///< including those before the preceding late ticks
    std::uint32_t missed_periods = 0;       ///< periods of the device without a measurement
    // Measured by the clock; NaN in lockstep, which has no clock.
    double clock_s = std::numeric_limits<double>::quiet_NaN();    ///< start, since the servo began
    double lateness_s = std::numeric_limits<double>::quiet_NaN(); ///< from deadline to start
    double period_s = std::numeric_limits<double>::quiet_NaN();   ///< since the last tick began
    double read_s = std::numeric_limits<double>::quiet_NaN();     ///< duration of `read`
    double compute_s = std::numeric_limits<double>::quiet_NaN();  ///< from measurement to command
    double write_s = std::numeric_limits<double>::quiet_NaN();    ///< duration of `write`
};

/// What the next tick's AlphaSources::before is after a tick with this contact and this active α.
/// RT-safe.
[[nodiscard]] inline double alpha_in_contact(const contact::Contact &contact,
                                             double alpha_rad2_per_m2) noexcept {
    return contact.touching ? alpha_rad2_per_m2 : std::numeric_limits<double>::infinity();
}

// What the law finds in a tick, as its sample holds it.

/// Notes η, α, x_Sd and θ_Sd, and the direction errors that both maps would render at rest. Uses
/// the sample's contact. RT-safe.
void note_law(const control::HapticLaw &law, const control::Configuration &now,
              const control::LawOutcome &found, ServoSample &sample) noexcept;

/// Notes the direction error of the sample's tip force against its contact; NaN without a force
/// that has a direction. RT-safe.
void note_rendered_error(ServoSample &sample) noexcept;

} // namespace springdrive::servo

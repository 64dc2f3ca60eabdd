// How warming changes a held contact, and what happens when R̂ is tuned on hot motors.
//
// The device is locked; the transpose map (23) at the bound (29) holds a set-point beyond it, so
// that the windings carry the static currents of (11), i = K_P (θ_Sd − θ)/dR. They warm, R(T) and
// with it dR (7) rise, K_DC (13) falls, and because no two motors carry the same current the force
// turns away from the normal. Then the operator tunes R̂ on the hot motors to restore dR and
// releases the contact, and the motors cool: R falls towards R̂ and, unless something limits R̂,
// below it.
#pragma once

#include "base/table.h"
#include "base/vector.h"
#include "device/core/device_description.h"
#include "device/core/motor/winding_heat.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/tuning.h"

#include <cstdint>
#include <limits>
#include <ostream>
#include <vector>

namespace springdrive::limits {

struct ThermalHoldOptions {
    double force_N = 0.0; ///< the tip's force at the start
    double seconds = 0.0; ///< duration of the hold, and of the cooling after it
    int rows = 60;        ///< per phase, its first and last moment included
    Vector3 q_rad = device::default_pose_rad();
    Vector3 direction{Vector3::UnitY()}; ///< the normal n that the force is to have, of any length
    control::Tuning tuning;              ///< dR and K_P; the hold sets its own gap, without η
    double ambient_C = device::kReferenceTemperature_C;
};

enum class ThermalPhase : std::uint8_t {
    hold, ///< R̂ as tuned on the cold motors
    cool, ///< R̂ as tuned on the hot motors, no current
};

/// One moment of the experiment. "Asked" is R̂ as the operator tunes it on the motor in its present
/// state: R(T, θ) − dR. "Allowed" is that value limited by `WindingGuard`, which is applied to the
/// motors.
struct ThermalRow {
    double time_s = 0.0;
    ThermalPhase phase = ThermalPhase::hold;
    Vector3 winding_C{Vector3::Zero()};
    Vector3 R_hat_asked_Ohm{Vector3::Zero()};
    Vector3 R_hat_allowed_Ohm{Vector3::Zero()}; ///< the smaller of asked and limit
    Vector3 dR_unlimited_Ohm{Vector3::Zero()};  ///< R − R̂ as asked, at the angle held
    Vector3 dR_Ohm{Vector3::Zero()};            ///< R − R̂ as allowed, at the angle held
    /// The same at the commutator's worst angle, to which a released device may turn.
    Vector3 min_dR_unlimited_Ohm{Vector3::Zero()};
    Vector3 min_dR_Ohm{Vector3::Zero()};
    Vector3 K_DC_Nm_per_rad{Vector3::Zero()}; ///< (13) with dR as allowed
    double tip_force_N = 0.0;
    double direction_error_rad = std::numeric_limits<double>::quiet_NaN(); ///< NaN without force
    /// L/|dR|: the time in which, without the limit, the current of the most over-cancelled winding
    /// would grow e-fold at the worst angle; NaN where none is over-cancelled.
    double growth_time_s = std::numeric_limits<double>::quiet_NaN();
    /// The safety monitor estimates that a winding is too hot: it brakes, and this row is the last.
    bool tripped = false;
};

/// Both phases, row by row.
///
/// Winding temperatures are integrated exactly over steps of at most 10 ms; the currents are
/// constant over a step, at their static value. Their own time constant L/dR is below 22 ms for
/// every dR that an RE 25 can be given, one five-hundredth of its winding's thermal time constant
/// of 12 s.
/// @throw InputError force or seconds not positive, not finite or beyond a day; rows outside 2 to
///        100,000; q beyond the joint limits; a direction without length; air outside the range
///        that `WindingGuard` assumes; K_P of zero; a force beyond the tip's limit, a motor's peak
///        current or its supply.
[[nodiscard]] std::vector<ThermalRow> thermal_hold(const device::DeviceDescription &device,
                                                   const ThermalHoldOptions &options);

/// For programs; temperatures in °C, angles in degrees.
[[nodiscard]] Table thermal_table(const std::vector<ThermalRow> &rows);

/// For people: some rows of each phase, and a summary.
void write_thermal_table(std::ostream &out, const std::vector<ThermalRow> &rows);

} // namespace springdrive::limits

// Whether a rotor's measured rotation agrees with its winding's current.
//
// Over an interval with a held e_W, (1) with (6) integrates to
//
//   ∫e_W dt + R̂ ∫i dt − L Δi = R ∫i dt + V_b T + k_T Δθ
//
// with V_b the voltage of brushes and bridge, which has the sign of the current. Of the right side
// only bounds are known: R in its tolerance and between the bounds of its temperature, V_b up to
// kMaxBrush_V, k_T, the sensor's offset, and e_W within a share. An encoder that is dead, scaled,
// reversed or of another motor reads a Δθ outside them.
//
// Two cumulative sums (Page), one for either direction, add up by how much the measured rotation is
// beyond its bounds, and lose by how much it is within. Roundings, and commands that act earlier or
// later than known, telescope in them. Nothing here is an estimate that a wrong encoder could have
// taught, except:
//
// At a level of the current, R + V_b/i is known better than either of them: while the current is
// steady, intervals intersect what is known of it. It widens by heat, by the angle's ripple, and by
// what V_b and the offset make of another level. A hand that moves a dead encoder's motor slower
// than this widens is not noticed.
#pragma once

#include "device/core/device_file.h"
#include "engine/control/resistance_observer.h"

#include <optional>

namespace springdrive::servo {

/// By how much R may be anything at an instant [Ω].
struct ResistanceBounds {
    double min_Ohm = 0.0;
    double max_Ohm = 0.0;
};

/// The test of one motor. RT-safe after construction.
class MotorConsistency {
public:
    MotorConsistency(const device::DeviceDescription &device, std::size_t motor, double period_s);

    /// Sets T; keeps the sums. RT-safe.
    void set_period(double period_s) noexcept;

    /// Takes an interval into account.
    /// @param min_C, max_C  bounds of the winding's temperature
    void update(const control::DrivenInterval &interval, double min_C, double max_C) noexcept;

    void reset() noexcept;

    /// The rotation that nothing explains [rad], and how much of it is a contradiction.
    [[nodiscard]] double unexplained_rad() const noexcept;
    [[nodiscard]] double limit_rad() const noexcept { return limit_rad_; }

private:
    /// Of R i + V_b at a current, as a share of it.
    struct Level {
        double current_A = 0.0; ///< with its sign
        ResistanceBounds drop;
    };
    /// Sums while the current is steady.
    struct Window {
        double duration_s = 0.0;
        double voltage_Vs = 0.0; ///< left side
        double charge_As = 0.0;
        double turned_rad = 0.0;
        double min_A = 0.0;
        double max_A = 0.0;
    };

    [[nodiscard]] ResistanceBounds drop_V(double current_A,
                                          const ResistanceBounds &R) const noexcept;
    [[nodiscard]] ResistanceBounds at_level(double current_A) const noexcept;
    void learn(const control::DrivenInterval &interval, double voltage_Vs, double mean_A) noexcept;
    void end_window() noexcept;

    device::MotorParameters motor_;
    device::CurrentSensing sensing_;
    double tolerance_; ///< of R, as the amplifier sees it
    double k_T_tolerance_;
    double limit_rad_ = 0.0;
    double above_Vs_ = 0.0; ///< measured rotation beyond its upper bound
    double below_Vs_ = 0.0;
    Window window_;
    std::optional<Level> level_;
};

} // namespace springdrive::servo

// Whether a rotor's measured rotation agrees with its winding's current.
//
// Over an interval with a held e_W, (1) with (6) integrates to
//
//   ∫e_W dt + R̂ ∫i dt − L Δi = R ∫i dt + V_b T + k_T Δθ
//
// with V_b the voltage of brushes and bridge, which has the sign of the current. Of the right side
// only bounds are known: R in its tolerance and between the bounds of its temperature, V_b up to
// max_brush_voltage_V, k_T, the sensor's offset, and e_W within a share. An encoder that is dead,
// scaled, reversed or of another motor reads a Δθ outside them.
//
// Two cumulative sums (Page), one for either direction, add up by how much the measured rotation is
// beyond its bounds, and lose by how much it is within. Roundings, and commands that act earlier or
// later than known, telescope in them. Nothing here is an estimate that a wrong encoder could have
// taught, except:
//
// At a level of the current, R + V_b/i is known better than either of them: while the current is
// steady, intervals intersect what is known of it, at the present angle and in the mean over all.
// That widens by heat, by the angle's ripple, up to its amplitude, and by what V_b and the offset
// make of another level. A hand that moves a dead encoder's motor slower than this is not noticed.
#pragma once

#include "device/core/device_description.h"
#include "engine/control/winding_observer.h"

#include <algorithm>
#include <optional>

namespace springdrive::servo {

/// By how many periods a command may act earlier or later than known.
inline constexpr double kDelay_periods = 0.3;

/// Between what a quantity is known to be, in the unit that its name has.
struct Bounds {
    double min = 0.0;
    double max = 0.0;

    [[nodiscard]] Bounds wider(double below, double above) const {
        return {min - below, max + above};
    }
    /// What both say, or this alone where they contradict each other.
    [[nodiscard]] Bounds and_also(const Bounds &other) const {
        const Bounds both{std::max(min, other.min), std::min(max, other.max)};
        return both.min <= both.max ? both : *this;
    }
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
    /// A steady current, and what is known of R + V_b/i at it.
    struct Level {
        double current_A = 0.0; ///< with its sign
        Bounds here_Ohm;        ///< at the present angle
        Bounds mean_Ohm;        ///< over the angles
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

    [[nodiscard]] Bounds drop_V(double current_A, const Bounds &R_Ohm) const noexcept;
    [[nodiscard]] Bounds at_current(double current_A, const Bounds &known_Ohm) const noexcept;
    [[nodiscard]] Bounds apparent_Ohm(double current_A) const noexcept;
    void learn(const control::DrivenInterval &interval, double voltage_Vs, double mean_A) noexcept;
    void end_window() noexcept;

    device::MotorParameters motor_;
    device::CurrentSensing sensing_;
    double tolerance_; ///< of R, as the amplifier sees it
    double k_T_tolerance_;
    double ripple_Ohm_; ///< amplitude, at the most
    double limit_rad_ = 0.0;
    double above_Vs_ = 0.0; ///< measured rotation beyond its upper bound
    double below_Vs_ = 0.0;
    Window window_;
    std::optional<Level> level_;
};

} // namespace springdrive::servo

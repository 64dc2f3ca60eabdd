// Independent reference for which of a servo's faults can be detected in a tick: from the device's
// measurement and the window's inputs, with its own formulae instead of the safety monitor's.
//
// For each cause two results: whether it *may* be called a fault, and whether it *must*. They
// differ by round-off, or, where the limit is the monitor's own choice, by a margin that any choice
// must respect.
#pragma once

#include "engine/control/haptic_law.h"
#include "engine/servo/servo_loop.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace springdrive::testing {

struct Finding {
    bool may = false;
    bool must = false;
    double measured = 0.0;
    double limit = 0.0;
};

inline constexpr std::size_t kTripCauses = servo::kTripCauseNames.size();

/// Whether a cause is checked before another.
[[nodiscard]] constexpr bool precedes(servo::TripCause first, servo::TripCause second) {
    const auto place = [](servo::TripCause cause) {
        return cause == servo::TripCause::motor_contradicted
                   ? 2 * static_cast<int>(servo::TripCause::encoder_jump) + 1
                   : 2 * static_cast<int>(cause);
    };
    return place(first) < place(second);
}

/// Tip and J = ∂x/∂θ at motor angles: docs/design.md, "Linkage and motors", written out.
struct TipAt {
    TipAt(const device::PhantomGeometry &geometry, const Vector3 &theta_rad);

    Vector3 q_rad;
    Vector3 tip_m;
    Matrix3 J;

    /// The tip force of winding currents [N], J⁻ᵀ k_T i.
    [[nodiscard]] Vector3 force_N(const Vector3 &torque_Nm) const;
};

class FaultJudge {
public:
    FaultJudge(const device::DeviceDescription &device, double period_s);

    /// Advances by one tick: the device's measurement, and the servo's result.
    void look(const device::Measurement &measured, const servo::ServoInputs &inputs,
              const servo::TickTiming &timing, const servo::ServoSample &sample);

    /// Resets the state, as the monitor is reset in the next tick.
    void reset();

    [[nodiscard]] const Finding &of(servo::TripCause cause) const {
        return findings_[static_cast<std::size_t>(cause)];
    }
    /// The first cause that must trip, in their order; none if none must.
    [[nodiscard]] servo::TripCause first_must() const;
    [[nodiscard]] double generated_J() const { return generated_J_; }
    [[nodiscard]] double upper_winding_C() const { return winding_C_.maxCoeff(); }

private:
    void find(servo::TripCause cause, double measured, double limit, double slack);
    void look_at_link(const device::Measurement &measured, const servo::SafetyLimits &limits);
    void look_at_window(const servo::ServoInputs &inputs, const servo::TickTiming &timing,
                        const servo::SafetyLimits &limits);
    void look_at_currents(const Vector3 &current_A, const servo::ServoSample &sample);
    void look_at_motion(const TipAt &now, const servo::ServoSample &sample, double since_last_s);
    void look_at_stops(const Vector3 &q_rad, double limit_rad);
    void look_at_energy(const TipAt &now, const Vector3 &force_N, const servo::ServoSample &sample);
    void look_at_voltage(const Vector3 &permissible_V, const servo::ServoSample &sample);

    /// The part of a requested command that force and current limits allow.
    struct Permissible {
        double share = 1.0;
        Vector3 e_W_V{Vector3::Zero()};
    };
    [[nodiscard]] Permissible permissible(const TipAt &now, const device::DeviceCommand &requested,
                                          const Vector3 &trim_V,
                                          const servo::ServoSample &sample) const;

    device::DeviceDescription device_;
    control::HapticLaw law_;
    Vector3 k_T_;
    double period_s_;
    std::array<Finding, kTripCauses> findings_{};

    bool has_previous_ = false;
    Vector3 theta_rad_{Vector3::Zero()};
    Vector3 rate_rad_per_s_{Vector3::Zero()};
    bool has_tip_ = false;
    Vector3 tip_m_{Vector3::Zero()};
    std::uint32_t heartbeat_ = 0;
    double silent_s_ = 0.0;
    double stale_s_ = 0.0;
    bool board_has_faults_ = false;
    bool is_resetting_board_ = false;
    double since_board_reset_s_ = 0.0;
    double elapsed_s_ = 0.0;        ///< since the last tick
    std::uint64_t period_ = 0;      ///< of the device, in the last tick
    std::uint64_t told_period_ = 0; ///< the same in the last tick with a new measurement
    Vector3 current_A_{Vector3::Zero()};
    Vector3 winding_C_;
    Vector3 housing_C_;
    servo::SafetyState state_ = servo::SafetyState::waiting; ///< after the last tick
    bool has_energy_ = false;
    Vector3 energy_tip_m_{Vector3::Zero()};
    Vector3 energy_force_N_{Vector3::Zero()};
    double stored_J_ = 0.0;
    double held_J_ = 0.0;
    double generated_J_ = 0.0;
    double share_ = 1.0; ///< of the force passed on in the last tick
    int may_volts_ = 0;  ///< ticks in a row
    int must_volts_ = 0;
};

} // namespace springdrive::testing

// A PHANTOM without hardware: motors behind spring-drive amplifiers, a massless linkage with a
// mass at its tip, quantising encoders, and a hand that holds the tip.
//
// In motor coordinates, J = ∂x/∂θ, tip and hand mass m, rotor inertia J_m, hand force F:
//
//   L di/dt = e_W − dR i − k_T θ̇                                   (11) with (6), each motor
//   (J_m + m JᵀJ) θ̈ + m Jᵀ J̇ θ̇ = k_T i − N⁻² b θ̇ + Jᵀ F          (3), J for the linkage
//   F = k (x_target − x) + b_hand (ẋ_target − ẋ)                    the hand, limited in force
//
// One sub-step of h takes the winding exactly for a standing rotor velocity and the rest by the
// implicit midpoint rule, both at the same mean velocity v̄: the work k_T ī·v̄ that leaves the
// windings is, to the last bit, the work that reaches the rotors. Second order in h.
#pragma once

#include "base/latest_value.h"
#include "device/haptic_device.h"
#include "device/simulated/hand_path.h"

#include <array>
#include <optional>

namespace springdrive {

/// A hand that holds the tip: a mass on it, drawn to a moving target by a spring and a damper.
/// The defaults are a relaxed pen grip, of the order that the literature on grips gives.
struct HandParameters {
    double mass_kg = 0.1;
    double damping_Ns_per_m = 6.0;
    double stiffness_N_per_m = 300.0;
    double greatest_force_N = 5.0;       ///< of the spring: no hand pushes without bound
    double greatest_speed_m_per_s = 0.4; ///< of a target moved by `set_hand_target`
};

struct SimulationOptions {
    double servo_period_s = 1e-3;   ///< T; each exchange advances the plant by as much
    int delay_samples = 0;          ///< d, at most kLongestDelay
    bool quantised_encoders = true; ///< false: 10,000 times as many counts
    double longest_step_s = 25e-6;  ///< sub-steps are not longer than this
    HandParameters hand;
    std::optional<HandPath> path; ///< the hand follows it; else `set_hand_target`
};

class SimulatedPhantom final : public HapticDevice {
public:
    static constexpr int kLongestDelay = 8;

    /// The tip starts at rest at `start_tip_m`, held by a hand whose target is there.
    /// @throw InputError where `start_tip_m` is out of reach or an option is out of range.
    SimulatedPhantom(const DeviceDescription &description, const SimulationOptions &options,
                     const Vector3 &start_tip_m);

    [[nodiscard]] const DeviceDescription &description() const override { return description_; }
    [[nodiscard]] int delay_samples() const override { return options_.delay_samples; }
    DeviceState exchange(const DeviceCommand &command) noexcept override;

    /// Where the hand wants to be from now on [m]. One thread at a time, any thread; without
    /// effect while the hand follows a path. The hand moves there smoothly.
    void set_hand_target(const Vector3 &target_m) noexcept { hand_target_.publish(target_m); }

    /// What no device would tell: the state behind the encoders. Thread of `exchange` only.
    struct Truth {
        double time_s = 0.0;
        Vector3 theta_rad{Vector3::Zero()};
        Vector3 theta_rate_rad_per_s{Vector3::Zero()};
        Vector3 current_A{Vector3::Zero()};
        Vector3 tip_m{Vector3::Zero()};
        Vector3 tip_velocity_m_per_s{Vector3::Zero()};
        Vector3 hand_target_m{Vector3::Zero()};
        Vector3 hand_force_N{Vector3::Zero()}; ///< on the tip, mean over the last period
    };
    [[nodiscard]] const Truth &truth() const { return truth_; }

private:
    [[nodiscard]] Vector3 step(const DeviceCommand &command, double h) noexcept;
    void move_hand_target(double h) noexcept;

    DeviceDescription description_;
    SimulationOptions options_;
    double counts_per_rad_ = 0.0;
    LatestValue<Vector3> hand_target_;
    HandTarget hand_;
    Truth truth_;
    Vector3 last_mean_rate_rad_per_s_{Vector3::Zero()};
    std::array<DeviceCommand, kLongestDelay + 1> pending_{}; ///< newest first
};

} // namespace springdrive

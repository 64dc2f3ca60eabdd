// A simulated PHANTOM: motors behind amplifiers, the linkage with its masses, friction and stops,
// quantising encoders, and a hand that holds the tip. In joint coordinates, θ = N q:
//
//   L di/dt = e_A − R(T, θ) i − V_b tanh(i/i_b) − k_T(T, θ) θ̇        (1), (2), (6), each motor
//   (M(q) + N² J_m) q̈ + C q̇ + g = N k_T i − b q̇ − friction + stops + Jᵀ F      (3), J = ∂x/∂q
//   F = k (x_target − x) + b_hand (ẋ_target − ẋ) − m_hand ẍ          the hand, limited in force
//   k_T(T, θ) = k_T [1 − a (T − 25 °C)] [1 + c cos(s θ + φ)]   T of the magnet, that is the housing
//
// V_b, of brushes and bridge (brushes.h), heats neither winding nor housing: the bridge's share is
// not in the motor, and of half a volt at 1 A the housing would be warmer by 7 K after half an
// hour.
//
// With structural compliance the hand holds a separate mass, connected to the end of the linkage by
// a spring and a damper. With cable compliance the rotors are bodies of their own, and motors and
// encoders see them, θ ≠ N q; without N² J_m the linkage has in place of N k_T i
//
//   N [κ (θ − N q) + c (θ̇ − N q̇)]       J_m θ̈ = k_T i − κ (θ − N q) − c (θ̇ − N q̇), each motor
//
// Disabled parts are not computed (PlantDynamics, SimulationOptions::planar): without inductance
// the currents follow (11) with L = 0 immediately; without masses the second equation becomes a
// static balance; in a plane the base joint and its motor are at rest. The set of parts can change
// between two periods: angles, rates and currents are kept.
//
// A sub-step integrates the winding exactly for a constant rotor velocity
// (device/core/motor/motor.h) and the mechanics by an energy-exact step (linkage_step.h), both at
// the same mean velocity: the work that leaves the windings equals, to round-off, the work that
// reaches the rotors. Second order in the sub-step; first order only where friction stops a joint
// or an amplifier reaches its limit.
#pragma once

#include "base/hand_over.h"
#include "base/split_mix.h"
#include "base/vector.h"
#include "device/core/device_description.h"
#include "device/core/haptic_device.h"
#include "device/simulated/linkage_step.h"
#include "device/simulated/plant_setup.h"
#include "device/simulated/simulation_options.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <string>

namespace springdrive::simulated {

/// A force that is affine in the mean velocity of the body it acts on: F − b v̄.
struct VelocityLoad {
    Vector3 force_N{Vector3::Zero()};
    double damping_Ns_per_m = 0.0;
};

/// A tip connected to the end of the linkage by a compliant structure: a mass behind a spring and a
/// damper, moved by a hand.
///
/// Over a step, with s the stretch at its start, ẋ̄ and ē the mean velocities of tip and linkage
/// end, and k_e = c + hk/2 of the structure:
///
///   m (ẋ₁ − ẋ₀)/h = F_hand − b_hand ẋ̄ − F       F = k s + k_e (ẋ̄ − ē)
///
/// so the spring acts with its mean stretch, and its work over the step is exact.
struct FreeTip {
    device::StructuralCompliance structure;
    double mass_kg = 0.0;
    Vector3 position_m{Vector3::Zero()};
    Vector3 velocity_m_per_s{Vector3::Zero()};

    /// The part of the tip's load that acts on the linkage's end, with ẋ̄ eliminated. RT-safe.
    [[nodiscard]] VelocityLoad at_linkage(const VelocityLoad &hand, const Vector3 &linkage_end_m,
                                          double step_s) const {
        const Vector3 spring = structure.stiffness_N_per_m * (position_m - linkage_end_m);
        const double share = coupling(step_s) / impedance(hand, step_s);
        return {spring + share * (momentum_rate(step_s) + hand.force_N - spring),
                coupling(step_s) * (1.0 - share)};
    }

    /// Advances the tip over the step, given the motion of the linkage's end. RT-safe.
    void settle(const VelocityLoad &hand, const Vector3 &linkage_end_before_m,
                const Vector3 &mean_end_velocity_m_per_s, double step_s) {
        const Vector3 spring = structure.stiffness_N_per_m * (position_m - linkage_end_before_m);
        const Vector3 mean = (momentum_rate(step_s) + hand.force_N - spring +
                              coupling(step_s) * mean_end_velocity_m_per_s) /
                             impedance(hand, step_s);
        position_m += step_s * mean;
        velocity_m_per_s = 2.0 * mean - velocity_m_per_s;
    }

    [[nodiscard]] double energy_J(const Vector3 &linkage_end_m) const {
        return 0.5 * structure.stiffness_N_per_m * (position_m - linkage_end_m).squaredNorm() +
               0.5 * mass_kg * velocity_m_per_s.squaredNorm();
    }

private:
    [[nodiscard]] double coupling(double step_s) const {
        return structure.damping_Ns_per_m + 0.5 * step_s * structure.stiffness_N_per_m;
    }
    [[nodiscard]] double impedance(const VelocityLoad &hand, double step_s) const {
        return 2.0 * mass_kg / step_s + hand.damping_Ns_per_m + coupling(step_s);
    }
    [[nodiscard]] Vector3 momentum_rate(double step_s) const {
        return 2.0 * mass_kg / step_s * velocity_m_per_s;
    }
};

/// A torque that is affine in the mean rate of the body it acts on: τ − b ω̄.
struct RateTorque {
    double torque_Nm = 0.0;
    double damping_Nms_per_rad = 0.0;
};

/// A rotor behind the cable to its joint, in rotor coordinates. The same step as FreeTip's, with
/// the twist s = θ − N q at its start and k_e = c + hκ/2:
///
///   J_m (θ̇₁ − θ̇₀)/h = τ − b ω̄ − F       F = κ s + k_e (ω̄ − N q̄̇)
///
/// with τ − b ω̄ from the winding, whose mean current is affine in ω̄.
struct FreeRotor {
    device::CableCompliance cable;
    double inertia_kg_m2 = 0.0;
    double twist_rad = 0.0;
    double rate_rad_per_s = 0.0;

    /// The cable's torque on the joint over N, F above with ω̄ eliminated: affine in N q̄̇. RT-safe.
    [[nodiscard]] RateTorque at_joint(const RateTorque &drive, double step_s) const {
        const double spring_Nm = cable.stiffness_Nm_per_rad * twist_rad;
        const double share = coupling(step_s) / impedance(drive, step_s);
        const double uncoupled = inertial(step_s) + drive.damping_Nms_per_rad;
        return {spring_Nm +
                    share * (inertial(step_s) * rate_rad_per_s + drive.torque_Nm - spring_Nm),
                share * uncoupled}; // k_e (1 − share), without cancellation
    }

    /// Advances the rotor over the step, given N q̄̇; returns ω̄. RT-safe.
    double settle(const RateTorque &drive, double mean_joint_rate_rad_per_s, double step_s) {
        const double mean = (inertial(step_s) * rate_rad_per_s + drive.torque_Nm -
                             cable.stiffness_Nm_per_rad * twist_rad +
                             coupling(step_s) * mean_joint_rate_rad_per_s) /
                            impedance(drive, step_s);
        twist_rad += step_s * (mean - mean_joint_rate_rad_per_s);
        rate_rad_per_s = 2.0 * mean - rate_rad_per_s;
        return mean;
    }

    [[nodiscard]] double energy_J() const {
        return 0.5 * cable.stiffness_Nm_per_rad * twist_rad * twist_rad +
               0.5 * inertia_kg_m2 * rate_rad_per_s * rate_rad_per_s;
    }

private:
    [[nodiscard]] double coupling(double step_s) const {
        return cable.damping_Nms_per_rad + 0.5 * step_s * cable.stiffness_Nm_per_rad;
    }
    [[nodiscard]] double impedance(const RateTorque &drive, double step_s) const {
        return inertial(step_s) + drive.damping_Nms_per_rad + coupling(step_s);
    }
    [[nodiscard]] double inertial(double step_s) const { return 2.0 * inertia_kg_m2 / step_s; }
};

/// The converter that digitises a motor's current for the servo. RT-safe. The noise is a sequence
/// that depends on the seed only.
class CurrentConverter {
public:
    explicit CurrentConverter(std::uint64_t seed) : seed_(seed) {}

    /// gain · i + offset + noise, rounded to the resolution [A].
    [[nodiscard]] double reading_A(const MotorSensing &sensing, double current_A) noexcept {
        double reading_A = sensing.converter.gain * current_A + sensing.converter.offset_A;
        if (sensing.noise_A > 0.0) {
            reading_A += sensing.noise_A * normal();
        }
        return sensing.resolution_A > 0.0
                   ? sensing.resolution_A * std::nearbyint(reading_A / sensing.resolution_A)
                   : reading_A;
    }

private:
    /// Mean 0, variance 1, to within 6: the sum of twelve uniform values (Irwin-Hall).
    [[nodiscard]] double normal() noexcept {
        double sum = -6.0;
        for (int i = 0; i < 12; ++i) {
            sum += split_mix::unit_share(split_mix::value(seed_, draws_++));
        }
        return sum;
    }

    std::uint64_t seed_;
    std::uint64_t draws_ = 0;
};

/// Command to the windings: volts for a spring drive, or amperes for a current drive, which only a
/// simulated device has.
struct PlantCommand {
    device::DeviceCommand spring_drive;
    Vector3 current_A{Vector3::Zero()};
};

/// The only simulated device. Each seed makes another one of it, with a serial number of its own;
/// of a seed with more digits than fit into a board's identity the last ten tell it.
[[nodiscard]] inline device::DeviceIdentity simulated_identity(std::uint64_t device_seed = 0) {
    constexpr std::uint64_t kTenDigits = 10'000'000'000;
    return {"simulated",
            device_seed == 0 ? "sim-1" : "sim-1-" + std::to_string(device_seed % kTenDigits),
            "simulated plant"};
}

class SimulatedPhantom final : public device::HapticDevice, public SimulatedWorld {
public:
    /// The tip starts at rest at `start_tip_m`, held by a hand whose target is there.
    /// @throw InputError if `start_tip_m` is out of reach or beyond the joint limits, or an option
    ///        is out of range.
    SimulatedPhantom(const device::DeviceDescription &description, const SimulationOptions &options,
                     const Vector3 &start_tip_m);

    [[nodiscard]] const device::DeviceDescription &description() const override {
        return description_;
    }
    [[nodiscard]] device::DeviceClock clock() const override { return device::DeviceClock::servo; }
    [[nodiscard]] bool can_reach_a_hand() const override { return false; }
    [[nodiscard]] double delay_periods() const override { return delay_periods_; }
    [[nodiscard]] device::Measurement read() noexcept override;
    void write(const device::DeviceCommand &command) noexcept override;
    [[nodiscard]] device::DeviceIdentity identity() const override {
        return simulated_identity(options_.device_seed);
    }
    [[nodiscard]] bool is_zeroed() const override { return is_zeroed_; }
    void set_period(double period_s) override;
    void zero(const Vector3 &theta_rad) override;
    void close() noexcept override { connected_ = false; }
    void reconnect() override;

    void set_hand_target(const Vector3 &target_m) noexcept override {
        hand_target_.publish(target_m);
    }
    void play(const HandStimulus &stimulus) noexcept override { stimulus_.publish(stimulus); }
    void hold_with(const device::HandParameters &hand) override;
    void simulate_as(const SimulationOptions &options) override;
    void follow(HandPath path) override;
    [[nodiscard]] Vector3 hand_m() const override { return hand_.position_m; }

    /// For a current drive, instead of `write`: the currents for its windings. RT-safe.
    void write_current(const Vector3 &current_A) noexcept;

    /// Advances by one period with a command: `write`, then `read`. RT-safe.
    device::Measurement advance(const device::DeviceCommand &command) noexcept {
        write(command);
        return read();
    }
    device::Measurement advance(const PlantCommand &command) noexcept;

    /// The true state, which no real device reports. Thread of `read` only.
    struct Truth {
        double time_s = 0.0;
        Vector3 theta_rad{Vector3::Zero()}; ///< of the rotors, which the encoders see
        Vector3 theta_rate_rad_per_s{Vector3::Zero()};
        Vector3 q_rad{Vector3::Zero()}; ///< of the linkage; θ = N q only without cable compliance
        Vector3 q_rate_rad_per_s{Vector3::Zero()};
        Vector3 current_A{Vector3::Zero()};
        Vector3 resistance_Ohm{Vector3::Zero()};           ///< R(T, θ)
        Vector3 torque_constant_Nm_per_A{Vector3::Zero()}; ///< k_T(T, θ)
        Vector3 brush_current_A{Vector3::Zero()};          ///< i_b
        Vector3 winding_C{Vector3::Zero()};
        Vector3 housing_C{Vector3::Zero()};
        Vector3 tip_m{Vector3::Zero()};
        Vector3 tip_velocity_m_per_s{Vector3::Zero()};
        Vector3 hand_target_m{Vector3::Zero()};
        Vector3 hand_force_N{Vector3::Zero()}; ///< on the tip, mean over the last period
    };
    [[nodiscard]] const Truth &truth() const { return truth_; }

    /// Kinetic energy (including the hand's mass), gravity, and the energy stored in windings,
    /// stops, cables and structure; without the hand's spring. No passive element can increase it.
    /// [J]
    [[nodiscard]] double stored_energy_J() const;

    /// Sets joint rates [rad/s] and winding currents [A], starting from rest. A quantity that is no
    /// state of the simulated dynamics follows the next command immediately.
    void set_in_motion(const Vector3 &q_rate_rad_per_s, const Vector3 &current_A);

private:
    using CurrentSteps = std::array<device::CurrentStep, 3>;
    using FreeRotors = std::array<FreeRotor, 3>;

    /// Of the rotors over a sub-step.
    struct RotorMotion {
        Vector3 mean_rate_rad_per_s{Vector3::Zero()};
        Vector3 end_rate_rad_per_s{Vector3::Zero()};
    };

    [[nodiscard]] device::Measurement measurement() noexcept;
    [[nodiscard]] double clock_s() const noexcept;
    void activate(const PlantParts &parts) noexcept;
    void connect_rotors() noexcept;
    void release_rotors() noexcept;
    void connect_tip() noexcept;
    void take_over(const PlantParts &requested) noexcept;
    [[nodiscard]] Vector3 run(const PlantCommand &command, double duration_s) noexcept;
    [[nodiscard]] Vector3 step(const PlantCommand &command, double h) noexcept;
    [[nodiscard]] CurrentSteps drive(const PlantCommand &command, double h) noexcept;
    [[nodiscard]] Vector3 linkage_end_m() const noexcept;
    [[nodiscard]] RateTorque drive_torque(const CurrentSteps &drive, Eigen::Index j,
                                          double gear) const noexcept;
    [[nodiscard]] LinkageLoad load(const CurrentSteps &drive, const VelocityLoad &tip,
                                   double h) const noexcept;
    [[nodiscard]] VelocityLoad hand_load(double h) const noexcept;
    [[nodiscard]] VelocityLoad with_weight(const VelocityLoad &hand) const noexcept;
    void set_angle_dependent(Eigen::Index motor, double theta_rad) noexcept;
    [[nodiscard]] device::CurrentStep drive_motor(Eigen::Index motor, const PlantCommand &command,
                                                  double h) noexcept;
    [[nodiscard]] RotorMotion settle_rotors(const CurrentSteps &drive, const LinkageMotion &motion,
                                            double h) noexcept;
    void settle_currents(const CurrentSteps &drive, const RotorMotion &rotors, double h) noexcept;
    void settle_tip(const LinkageMotion &motion, const VelocityLoad &hand,
                    const Vector3 &linkage_end_before_m, double h) noexcept;
    void warm_windings() noexcept;
    void move_hand_target(double h) noexcept;
    void note_rigid_tip() noexcept;
    void note_linkage(const LinkageState &linkage) noexcept;

    device::DeviceDescription description_;
    SimulationOptions options_;   ///< without path; read by other threads, too
    SimulationOptions requested_; ///< by the last `simulate_as`, for its thread
    PlantParts parts_;
    LatestValue<PlantParts> requested_parts_;
    std::uint32_t newest_parts_ = 0;        ///< their number, for the thread of `simulate_as`
    double delay_periods_;                  ///< of these, for the same thread
    std::optional<FreeTip> free_tip_;       ///< with structural compliance
    std::optional<FreeRotors> free_rotors_; ///< with cable compliance
    /// What θ exceeds N q by, beyond a cable's twist: left over from a cable that became rigid, so
    /// that neither encoder nor tip jumps. It fades.
    Vector3 residual_twist_rad_{Vector3::Zero()};
    Eigen::Index first_joint_ = 0; ///< that moves
    double counts_per_rad_ = 0.0;
    LatestValue<Vector3> hand_target_;
    std::optional<HandPath> path_;
    bool follows_path_; ///< until its end
    double path_start_s_ = 0.0;
    HandTarget hand_;
    LatestValue<HandStimulus> stimulus_;
    std::uint32_t stimulus_number_ = 0; ///< of the one that plays, or played last
    double stimulus_start_s_ = 0.0;
    HandTarget pull_target_; ///< of the hand, with the stimulus
    LinkageState linkage_;
    std::array<FrictionMode, 3> friction_mode_{};
    std::array<device::WindingTemperature, 3> temperature_;
    std::array<CurrentConverter, 3> converter_;
    Vector3 heat_J_{Vector3::Zero()};    ///< in the windings, since the last period
    Vector3 carried_A_{Vector3::Zero()}; ///< mean of |i| through the brushes' film
    Truth truth_;
    PlantCommand written_; ///< last
    /// Active command of each period, newest first.
    std::array<PlantCommand, SimulationOptions::kMaxDelay + 2> pending_{};
    std::uint64_t periods_ = 0;
    double clock_base_s_ = 0.0; ///< the device's clock when its period was last set
    std::uint64_t clock_base_periods_ = 0;
    Vector3 count_zero_rad_{Vector3::Zero()}; ///< θ at which the counts are zero
    bool connected_ = true;
    bool is_zeroed_ = true;
    std::uint8_t zeroings_ = 0; ///< modulo 16
};

} // namespace springdrive::simulated

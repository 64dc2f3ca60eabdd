// A sine sweep of the rendered stiffness on a device, one tick after the other, so that a window
// and a command can both show it while it goes on:
//
//   rest ──► hold the tip where it is ──► observe R ──► each motor, each frequency ──► release
//                                                        │
//                            amplitude ──► settle ──► blocks until K_θ is known well enough
//
// The set-point is locked by the inverse map (18), so that every motor renders K_θ(s) by itself
// (12). The excitation is a voltage on the motor that is measured, and passes the safety monitor
// like everything else. Its amplitude is as large as shares of the limits of force, motion, current
// and energy allow.
#pragma once

#include "device/core/haptic_device.h"
#include "engine/control/tuning.h"
#include "engine/lab/loops/rendered_stiffness.h"
#include "engine/servo/servo.h"

#include <Eigen/Core>

#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace springdrive::commissioning {

// The rendered stiffness from amplitudes measured under excitation.
//
// The servo is software: its share of e_W for a motion is known. What is not known is the amplifier
// with its winding, on which e_W and the back-EMF act alike (1), (6):
//
//   I = Y(jω) [ H(jω) E − k_T jω Θ ],     H(jω) = e^(−jωdT) (1 − e^(−jωT))/(jωT)
//
// With a locked set-point and no excitation E = −C(e^(jωT)) Θ (docs/design.md, "Sampled forms"), so
// that the stiffness is
//
//   K_θ = −k_T I/Θ = k_T Y [ C H + k_T jω ]
//
// whatever moved the rotor while Y was measured. Y contains dR, L, the amplifier's loop and the
// gains of its sensors and stages; k_T follows from the back-EMF of the whole sweep. T and d are
// taken as known, and that the torque is k_T times the current that the sensor reads.
//
// I and Θ are sampled once in a period, while currents and rotor also move with each step of e_W:
// those aliases are some per cent near a tenth of the servo rate. They follow from the winding, dR
// and L, and the inertia that fit the whole sweep of a motor.

/// Of e^(jωt).
struct BlockAmplitudes {
    std::complex<double> excitation_V;
    std::complex<double> e_W_V; ///< as passed to the amplifier, excitation included
    std::complex<double> current_A;
    std::complex<double> theta_rad;
};

/// What belongs to one tick.
struct BlockSample {
    double time_s = 0.0; ///< of the measurement
    double excitation_V = 0.0;
    double e_W_V = 0.0;
    double current_A = 0.0;
    double theta_rad = 0.0;
};

/// The complex amplitudes of what was measured at one frequency, by least squares at the device's
/// own measurement times: beside the sine, a constant, a drift, and a slow dither of known
/// frequency.
class SweepBlock {
public:
    SweepBlock() = default;

    /// @param dither_rad_per_s  0: none
    SweepBlock(double omega_rad_per_s, double dither_rad_per_s, double duration_s)
        : omega_rad_per_s_(omega_rad_per_s), dither_rad_per_s_(dither_rad_per_s),
          duration_s_(duration_s) {}

    void take(const BlockSample &sample) noexcept;

    /// @pre  more ticks were taken than the sine has unknowns, over at least one period
    [[nodiscard]] BlockAmplitudes amplitudes() const;

private:
    static constexpr int kRegressors = 6; ///< 1, t, sine and dither
    static constexpr int kSignals = 4;

    double omega_rad_per_s_ = 0.0;
    double dither_rad_per_s_ = 0.0;
    double duration_s_ = 1.0;
    Eigen::Matrix<double, kRegressors, kRegressors> normal_ =
        Eigen::Matrix<double, kRegressors, kRegressors>::Zero();
    Eigen::Matrix<double, kRegressors, kSignals> products_ =
        Eigen::Matrix<double, kRegressors, kSignals>::Zero();
};

/// What was measured at one frequency.
struct SweepMeasurement {
    std::size_t motor = 0;
    double frequency_hz = 0.0;
    std::vector<BlockAmplitudes> blocks; ///< at least one
    double delay_periods = 0.0;
    double torque_constant_Nm_per_A = 0.0; ///< for which the law computed e_W
    double cancelled_Ohm = 0.0;            ///< R̂, which follows R while it is observed
    double excitation_V = 0.0;             ///< its amplitude

    [[nodiscard]] double omega_rad_per_s() const;
};

/// A winding with its amplifier and its rotor, as far as a resistance, an inductance and an inertia
/// describe them.
struct FittedWinding {
    double dR_Ohm = 0.0;        ///< beside this R̂; by as much less as another one is more
    double cancelled_Ohm = 0.0; ///< mean over the sweep
    double inductance_H = 0.0;
    double torque_constant_Nm_per_A = 0.0; ///< by the back-EMF
    double inertia_kg_m2 = 0.0; ///< of the rotor, with what moves with it above its resonances
};

/// A point of a larger deviation is not known well enough.
inline constexpr double kUncertain = 0.01;

/// One frequency's result.
struct SweepPoint {
    double frequency_hz = 0.0;
    std::complex<double> measured_Nm_per_rad;
    double deviation = 0.0; ///< standard deviation of it, as a share of its magnitude
    std::complex<double> sampled_Nm_per_rad;  ///< with the measured d
    std::complex<double> analytic_Nm_per_rad; ///< (12)
    double delay_periods = 0.0;
    double excitation_V = 0.0;

    /// By which the magnitude exceeds that of the sampled form, as a share of it.
    [[nodiscard]] double magnitude_error() const;
    /// By which the phase exceeds that of the sampled form [rad].
    [[nodiscard]] double phase_error_rad() const;
};

/// A motor's sweep.
struct MotorSweep {
    std::size_t motor = 0;
    FittedWinding winding;
    std::vector<SweepPoint> points; ///< by rising frequency
};

/// @param drive  the prediction: the file's motor, tuning and T; d is that of each measurement
/// @param measurements  of one motor, at least one
[[nodiscard]] MotorSweep estimate_sweep(const loops::SpringDrive &drive,
                                        std::span<const SweepMeasurement> measurements);

/// The deviation alone, for a winding as predicted.
[[nodiscard]] double estimated_deviation(const loops::SpringDrive &drive,
                                         const SweepMeasurement &measurement);

struct SweepOptions {
    std::vector<std::size_t> motors{0, 1, 2};
    double min_hz = 1.0;
    std::optional<double> max_hz; ///< a tenth of the servo rate
    int points = 12; ///< for each motor, at least two, evenly spaced on a logarithmic scale
    control::Tuning tuning;
    double servo_hz = 1000.0;
    /// Otherwise R̂ is that of the file, and what is measured shows how far R is from it.
    bool observes_resistance = true;
    /// The monitor's limit meanwhile; the excitation's own amplitude is below a third of it.
    double tip_force_N = 4.0;
    double motion_m = 1e-3; ///< amplitude of the tip
};

/// The same with their defaults, and with motors in order.
/// @throw InputError for options out of range, named as `device sweep` does
[[nodiscard]] SweepOptions checked_sweep_options(const device::DeviceDescription &device,
                                                 SweepOptions options);

enum class SweepStage : std::uint8_t { resting, holding, observing, measuring, releasing, done };

struct SweepReport {
    bool is_complete = false;
    std::string problem; ///< that ended it; empty if there was none, or if it was stopped
    std::vector<MotorSweep> motors; ///< with what was measured until then
    std::vector<std::string> warnings;
    unsigned discarded_blocks = 0; ///< since a measurement was late, or a limit acted

    /// Whether all was measured, and is known well enough.
    [[nodiscard]] bool is_certain() const;
    /// Whether every magnitude is within this share of the sampled form's, and every phase within
    /// this angle of its phase.
    [[nodiscard]] bool is_within(double share, double phase_rad) const;
};

class StiffnessSweep {
public:
    /// @param device  zeroed, and read and written by nobody else; outlives this
    /// @throw InputError for options out of range, or a device that is not zeroed or not fit
    StiffnessSweep(device::HapticDevice &device, const SweepOptions &options = {});

    /// One tick. @return whether there is more to do
    bool step();

    /// Brakes now. What was measured stays.
    void stop() noexcept;

    [[nodiscard]] SweepStage stage() const { return stage_; }
    /// What the person shall do now, or what is done.
    [[nodiscard]] std::string instruction() const;
    [[nodiscard]] double share() const; ///< of the whole
    [[nodiscard]] SweepReport report() const;

private:
    /// How a point is approached.
    enum class Phase : std::uint8_t { changing, trying, settling, measuring, fading };

    /// An amplitude, which changes without a step.
    struct Amplitude {
        double now_V = 0.0;
        double requested_V = 0.0;
        double rate_V_per_s = 0.0;

        void change(double to_V) noexcept;
        void pass(double time_s) noexcept;
    };

    /// Of a while, for the amplitude.
    struct Extent {
        Vector3 min_m{Vector3::Zero()};
        Vector3 max_m{Vector3::Zero()};
        Vector3 least_N{Vector3::Zero()};
        Vector3 most_N{Vector3::Zero()};
        double least_A = 0.0;
        double most_A = 0.0;
        double force_N = 0.0; ///< with what holds the tip
        double energy_J = 0.0;
        bool is_empty = true;

        void take(const servo::ServoSample &sample, Eigen::Index motor) noexcept;
    };

    /// A frequency of a motor, and its blocks of whole periods and ticks.
    struct Task {
        std::size_t motor = 0;
        long periods = 0;
        long ticks = 0;
    };

    void plan();
    void publish();
    [[nodiscard]] double excitation_V() noexcept;
    void act(const servo::ServoSample &sample);
    void rest(const servo::ServoSample &sample);
    void hold();
    void observe(const servo::ServoSample &sample);
    [[nodiscard]] double dither_V(const Task &task) const;
    void begin_task(double first_V);
    void end_task();
    void try_amplitude(double requested_V) noexcept;
    void measure(const servo::ServoSample &sample);
    [[nodiscard]] bool is_too_much(const servo::ServoSample &sample) const noexcept;
    [[nodiscard]] bool is_too_much_energy(const servo::ServoSample &sample) const noexcept;
    void retreat();
    void adapt();
    [[nodiscard]] double room() const noexcept;
    void begin_block();
    [[nodiscard]] bool is_clean(const servo::ServoSample &sample) const noexcept;
    void take_tick(const servo::ServoSample &sample);
    void take_block();
    void note_distrust();
    void enter(SweepStage stage) noexcept;
    void enter(Phase phase) noexcept;
    void end(std::string problem);
    [[nodiscard]] double block_s() const noexcept;
    [[nodiscard]] double largest_V() const noexcept;
    [[nodiscard]] loops::SpringDrive drive_of(std::size_t motor) const;
    [[nodiscard]] Eigen::Index motor_index() const noexcept;

    device::HapticDevice &device_;
    SweepOptions options_;
    servo::SafetyLimits limits_; ///< of the device
    servo::Servo servo_;
    servo::ServoInputs inputs_;
    servo::ServoSample sample_; ///< the last one
    bool has_sample_ = false;

    SweepStage stage_ = SweepStage::resting;
    int braked_ticks_ = 0;
    double stage_began_s_ = 0.0;
    double now_s_ = 0.0; ///< by the device's time, since the beginning
    double origin_s_ = 0.0;
    bool is_complete_ = false;
    std::string problem_;
    std::vector<std::string> warnings_;

    std::vector<Task> tasks_;
    std::size_t task_ = 0; ///< the present one
    Phase phase_ = Phase::changing;
    double phase_began_s_ = 0.0;
    Amplitude sine_;
    Amplitude dither_;
    bool is_rising_ = false;        ///< the sine, to what is tried
    double changing_s_ = 0.0;       ///< how long that lasts
    double dither_rad_per_s_ = 0.0; ///< 0: none
    int trials_ = 0;
    Extent extent_;

    SweepBlock block_;
    double block_began_s_ = 0.0;
    long block_ticks_ = 0;
    double delay_sum_ = 0.0;
    double k_T_sum_ = 0.0;
    double cancelled_sum_Ohm_ = 0.0;
    long summed_ticks_ = 0;
    SweepMeasurement measurement_; ///< at the present frequency
    std::vector<SweepMeasurement> measured_;
    unsigned discarded_ = 0;
    std::array<bool, 3> is_distrusted_{}; ///< and noted
};

} // namespace springdrive::commissioning

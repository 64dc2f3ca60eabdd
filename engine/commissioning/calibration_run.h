// Calibrates a device: R of each winding with the commutator's ripple, V_b of brushes and bridge,
// k_T and the current sensors' offsets, one tick after the other, so that a window and a command
// can both show it while it goes on:
//
//   rest ──► start: the gains ramp up ──► motion by hand, with a drag ──► release ──► done
//
// In free space the spring drive follows the hand without current, so that nothing is learned. So
// each motor resists the hand's motion, like friction, by a current between two levels, at another
// frequency than the others':
//
//   i = −[I₀ + ½ (I − I₀)(1 − cos 2π f t)] c
//   c = s + θ̇/ω within ±1,  ds = (dθ − |dθ| s)/δ − s dt/τ
//
// However slowly the rotor turns, there are both levels in both directions at each angle. That
// separates R from V_b, which differ by nothing else, from the sensor's offset and from k_T. A V_b
// that a current has to overcome is added to e_W until the levels are reached.
//
// The hand is given back at most what a spring over δ holds, a few mm at the tip; a device that is
// held still is without force after some τ.
//
// R and V_b are those of BrushFit, which knows i_b and the way of heat; all else is the servo's
// observers', whose R and V_b must agree.
#pragma once

#include "device/core/device_description.h"
#include "device/core/haptic_device.h"
#include "engine/commissioning/brush_fit.h"
#include "engine/commissioning/self_test.h"
#include "engine/servo/servo.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace springdrive::commissioning {

struct CalibrationOptions {
    double drag_N = 1.5;             ///< of one motor, at the end of its link, at most
    double longest_motion_s = 180.0; ///< for moving the device by hand
    std::optional<double> air_C;     ///< by a thermometer, to kThermometer_K
    double dR_Ohm = 0.5;             ///< for which R̂ is reported
    std::int64_t made_at_s = 0;      ///< UTC, since 1970; 0: now
    bool lets_go_on = false;         ///< see SelfTestOptions
};

/// By how much a room's thermometer may be wrong, either way, the motors' air included.
inline constexpr double kThermometer_K = 2.0;

enum class CalibrationStage : std::uint8_t { rest, start, motion, release, done };

/// What a motor's resistance may be cancelled by, with what is known of it.
struct Cancellable {
    double R_hat_Ohm = 0.0;  ///< for the dR that was asked for, averaged over the angles
    double min_dR_Ohm = 0.0; ///< that observer and winding guard permit, with 3 deviations
};

struct MotorCalibrationReport {
    Cancellable before;      ///< at a start without calibration
    Cancellable at_start;    ///< at one with it, until a touch has told more
    Cancellable now;         ///< at the end, as warm as it was, in the air of the calibration
    double turned_rad = 0.0; ///< of the rotor, to and fro
};

/// What ended a calibration without a result.
enum class CalibrationProblem : std::uint8_t {
    none,
    ended,           ///< by a person
    stopped,         ///< by the safety monitor
    never_at_rest,   ///< so that the gains could not ramp up
    little_motion,   ///< not enough of it to know R, ripple and V_b
    contradiction,   ///< current sensor and encoder do not fit together, or not the file
    of_another_kind, ///< R or k_T beyond the file's tolerances
};

struct CalibrationReport {
    bool is_complete = false; ///< may be used and stored
    CalibrationProblem kind = CalibrationProblem::none;
    servo::TripCause trip = servo::TripCause::none; ///< of the safety monitor
    std::string problem;                            ///< in one line, why not, and what to do
    device::Calibration calibration;
    std::array<MotorCalibrationReport, 3> motor;
    double motion_s = 0.0; ///< duration
};

/// What is known of a motor by now, for display.
struct MotorProgress {
    double share = 0.0;          ///< 1 once R, ripple and V_b are known as well as they should be
    double resistance_Ohm = 0.0; ///< at 25 °C
    double deviation_Ohm = 0.0;  ///< standard, of R
    double moved_rad = 0.0;      ///< from the lowest to the highest angle of its joint
};

class CalibrationRun {
public:
    /// @param device  zeroed, and read and written by nobody else, at a rate of kRate_hz; outlives
    ///                this
    /// @param mover   in place of a person; not told when the motion is ended before its time
    /// @throw InputError for a device of which nothing can be learned, or options out of range
    explicit CalibrationRun(device::HapticDevice &device, const CalibrationOptions &options = {},
                            Mover mover = {});

    static constexpr double kRate_hz = 1000.0;

    /// One tick. The first ones reset the faults that a board has latched before.
    /// @return whether there is more to do
    bool step();

    [[nodiscard]] CalibrationStage stage() const { return stage_; }
    /// What the person shall do now, and what is still missing.
    [[nodiscard]] std::string instruction() const { return instruction(stage_, min_known()); }
    [[nodiscard]] static std::string instruction(CalibrationStage stage, std::size_t min_known);
    /// The motor of which least is known.
    [[nodiscard]] std::size_t min_known() const;
    /// RT-safe.
    [[nodiscard]] std::array<MotorProgress, 3> progress() const;
    /// Of the present stage.
    [[nodiscard]] double share() const;
    /// Whether all motors are known as well as they should be.
    [[nodiscard]] bool has_reached_all() const;

    /// The longest that the motion still lasts; before it, all of it [s].
    [[nodiscard]] double motion_left_s() const;

    /// Of a window that shall be able to stop it: another number each frame, from 1. Once there was
    /// one, its silence trips the safety monitor.
    void note_window(std::uint32_t heartbeat) { inputs_.heartbeat = heartbeat; }

    /// Ends the motion with what has been learned. The gains ramp down: go on with `step`.
    void finish();

    /// The last tick, for display; without a tick, its default.
    [[nodiscard]] const servo::ServoSample &sample() const { return sample_; }

    [[nodiscard]] CalibrationReport report() const;

private:
    void rest();
    void tick();
    void excite();
    void note_brushes();
    void watch_progress();
    void stop_for(CalibrationProblem kind, std::string problem);
    void refuse(CalibrationProblem kind, std::string problem);
    [[nodiscard]] double time_s() const;
    [[nodiscard]] device::MotorCalibration learned(std::size_t motor) const;
    [[nodiscard]] std::string contradiction(std::size_t motor) const;
    [[nodiscard]] double share_of(std::size_t motor) const;
    [[nodiscard]] device::Calibration calibration() const;

    device::HapticDevice &device_;
    CalibrationOptions options_;
    Mover mover_;
    device::BoardReset reset_;
    Vector3 drag_A_; ///< I
    CalibrationStage stage_ = CalibrationStage::rest;
    int ticks_ = 0; ///< in this stage
    servo::ServoInputs inputs_;
    std::unique_ptr<servo::Servo> servo_;
    Vector3 before_rad_{Vector3::Zero()}; ///< of the rotors, in the tick before
    Vector3 way_{Vector3::Zero()};        ///< s
    Vector3 brush_V_{Vector3::Zero()};    ///< that the currents take beside dR
    std::array<BrushFit, 3> fit_;
    std::array<BrushEstimate, 3> fitted_; ///< a second ago, and at the end
    servo::ServoSample sample_;
    std::array<device::MotorCalibration, 3> learned_;  ///< at the end of the motion
    std::array<device::MotorCalibration, 3> at_first_; ///< known before
    std::array<MotorCalibrationReport, 3> motor_;
    double best_share_ = 0.0; ///< of the motion
    int ticks_without_gain_ = 0;
    int motion_ticks_ = 0;
    int braking_ticks_ = 0; ///< at the end
    bool has_moved_ = false;
    bool is_complete_ = false;
    CalibrationProblem kind_ = CalibrationProblem::none;
    std::string problem_;
    Vector3 lowest_rad_{Vector3::Zero()}; ///< of the rotors, in the motion
    Vector3 highest_rad_{Vector3::Zero()};
};

} // namespace springdrive::commissioning

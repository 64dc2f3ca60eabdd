// Estimates R, k_T, V_b and the current's offset of each motor while the servo runs, from
// measurements and the commands that acted between them, and moves the values in use towards them
// without a step.
//
// One verdict: what is observed of one motor and not of another turns the force. While any motor is
// not trusted, all three are used as if nothing had been observed or calibrated: with the file's R
// at 25 °C and its uncertainty, the file's k_T, and no V_b. The temperature follows from a current
// that may be what is wrong. When all are trusted again, the values in use return to what is
// observed.
#pragma once

#include "device/core/haptic_device.h"
#include "engine/control/winding_observer.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

namespace springdrive::servo {

/// The parameters of a motor that the servo uses at its start: those of `known_at_start`, where the
/// mean R deviates by no less than that of an observation that is not settled.
[[nodiscard]] control::ObservedMotor used_at_start(const device::DeviceDescription &device,
                                                   std::size_t motor);

/// One WindingObserver per motor, and the values in use. RT-safe after construction.
class WindingObservers {
public:
    /// @param delay_periods  d, from a measurement to the command computed from it; above kMaxDelay
    ///                       no interval is known, and nothing is observed
    WindingObservers(const device::DeviceDescription &device, double delay_periods,
                     double period_s);

    /// Keeps the estimates. RT-safe.
    void set_timing(double delay_periods, double period_s) noexcept;

    // Once a tick `update` or `rest`, then `record`; without a new measurement `skip` alone.

    /// Observes the motors.
    /// @param theta_rad  motor angles of the measured counts
    /// @param is_next    whether the measurement follows the previous one by one period; otherwise
    ///                   only the windings' temperatures are updated
    void update(const device::Measurement &measured, const Vector3 &theta_rad, bool is_next,
                std::uint32_t missed_periods) noexcept;

    /// Observes nothing: only the windings' temperatures are updated, and the values in use
    /// approach those of the device file. Parameters as for `update`.
    void rest(const device::Measurement &measured, const Vector3 &theta_rad, bool is_next,
              std::uint32_t missed_periods) noexcept;

    /// A tick without a new measurement makes the next interval unknown.
    void skip() noexcept {
        known_commands_ = 0;
        has_previous_ = false;
    }

    /// Records the command that is sent in this tick.
    void record(const device::DeviceCommand &command) noexcept;

    /// From the next `restart` on, the zero of the counts is taken to be found by eye, as after a
    /// connection was lost.
    void forget_zero() noexcept {
        for (control::WindingObserver &observer : observer_) {
            observer.forget_zero();
        }
    }

    /// Forgets everything but the windings' temperatures; the values in use follow without a step.
    void restart() noexcept;

    /// Forgets what was observed of a motor, see WindingObserver::distrust.
    void distrust(std::size_t motor) noexcept {
        observer_[motor].distrust();
        is_restarted_ = true;
    }

    /// The values in use, at the motor angles of the last measurement.
    [[nodiscard]] const control::ObservedMotors &motors() const { return used_; }

    /// How a motor was driven between the last two measurements, after `rest` too. Empty if one of
    /// them or a command is missing, if the amplifier was open or reported a fault, and near its
    /// peak current.
    [[nodiscard]] const std::optional<control::DrivenInterval> &interval(std::size_t motor) const {
        return interval_[motor];
    }

    [[nodiscard]] const control::WindingObserver &observer(std::size_t motor) const {
        return observer_[motor];
    }

    /// The mean R of a winding as warm as the air; its deviation is infinite until the observation
    /// is settled.
    [[nodiscard]] control::ResistanceEstimate unheated(std::size_t motor) const noexcept {
        const control::ResistanceEstimate R = observer_[motor].unheated();
        return observer_[motor].is_settled()
                   ? R
                   : control::ResistanceEstimate{R.resistance_Ohm,
                                                 std::numeric_limits<double>::infinity()};
    }

private:
    static constexpr std::size_t kMaxDelay = 8;
    static constexpr std::size_t kHistory = kMaxDelay + 2;

    [[nodiscard]] static std::size_t whole_delay(double delay_periods) noexcept;
    [[nodiscard]] const device::DeviceCommand &command_before(std::size_t ticks) const noexcept;
    [[nodiscard]] bool find_intervals(const device::Measurement &measured, const Vector3 &theta_rad,
                                      bool is_next) noexcept;
    void skip_observers(const Vector3 &current_A, std::uint32_t missed_periods) noexcept;
    [[nodiscard]] bool are_trusted() const noexcept;
    [[nodiscard]] control::ObservedMotor known_of(std::size_t motor,
                                                  double theta_rad) const noexcept;
    void approach_constants(const control::ObservedMotor &known,
                            control::ObservedMotor &used) const noexcept;
    void approach(const Vector3 &theta_rad, const control::ObservedMotors &before) noexcept;

    double period_s_;
    double max_rate_Ohm_per_s_; ///< fastest change of a resistance in use, and of its deviation
    std::size_t whole_delay_;
    double delay_fraction_;
    std::array<control::WindingObserver, 3> observer_;
    std::array<device::MotorParameters, 3> motor_;
    control::ObservedMotors unobserved_; ///< by the file and its tolerances, at 25 °C
    control::ObservedMotors used_;
    bool uses_observations_ = true; ///< whether `used_` approaches them
    bool is_restarted_ = false;     ///< the next estimates are unrelated to the previous ones
    /// The value in use less the estimate; decays to zero.
    Vector3 transfer_offset_here_Ohm_{Vector3::Zero()};
    Vector3 transfer_offset_mean_Ohm_{Vector3::Zero()};

    std::array<device::DeviceCommand, kHistory> history_{};
    std::size_t newest_ = 0;         ///< index into history_
    std::size_t known_commands_ = 0; ///< recorded since the last gap
    bool has_previous_ = false;      ///< current_A_ and theta_rad_ are those of the last tick
    Vector3 current_A_{Vector3::Zero()};
    Vector3 theta_rad_{Vector3::Zero()};
    std::array<std::optional<control::DrivenInterval>, 3> interval_;
};

} // namespace springdrive::servo

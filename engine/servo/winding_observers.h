// Observes a device's motors, tick by tick, from what was measured and the commands that acted in
// between.
#pragma once

#include "device/core/haptic_device.h"
#include "engine/control/winding_observer.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

namespace springdrive::servo {

/// What is known of a motor when a servo starts, as it is used: until observations have agreed for
/// a while, no less than a share of R counts as its deviation.
[[nodiscard]] control::ObservedMotor used_at_start(const device::DeviceDescription &device,
                                                   std::size_t motor);

/// RT-safe after construction.
class WindingObservers {
public:
    /// @param delay_periods  d; with more than kMaxDelay nothing is ever learned
    WindingObservers(const device::DeviceDescription &device, double delay_periods,
                     double period_s);

    /// Keeps the estimates. RT-safe.
    void set_timing(double delay_periods, double period_s) noexcept;

    /// Once a tick, before its command: what was measured.
    /// @param theta_rad  angles of its counts
    /// @param is_next    whether it follows the one before by one period, which teaches something
    void take(const device::Measurement &measured, const Vector3 &theta_rad, bool is_next,
              std::uint32_t missed_periods) noexcept;

    /// A tick without a new measurement.
    void take_nothing() noexcept {
        known_commands_ = 0;
        has_previous_ = false;
    }

    /// What happened to a motor between the last two measurements, if that is known: also where
    /// nothing is observed. Empty near the limits of its amplifier.
    [[nodiscard]] const std::optional<control::DrivenInterval> &interval(std::size_t motor) const {
        return interval_[motor];
    }

    /// Once a tick, after `take`: the command that was sent.
    void note(const device::DeviceCommand &command) noexcept;

    /// From the next `restart` on, the counts' zero is taken to be found by eye, as after a
    /// connection was lost.
    void forget_zero() noexcept {
        for (control::WindingObserver &observer : observer_) {
            observer.forget_zero();
        }
    }

    /// Forgets everything but the windings' temperatures; what is used follows without a step.
    void restart() noexcept;

    /// Forgets what was observed of a motor, and observes it no more until `restart`.
    void distrust(std::size_t motor) noexcept {
        observer_[motor].distrust();
        begins_anew_[motor] = true;
    }

    /// While nothing is observed: the windings' temperatures follow, and what is used approaches
    /// the device file without a step.
    void rest(const device::Measurement &measured, const Vector3 &theta_rad, bool is_next,
              std::uint32_t missed_periods) noexcept;

    /// At the angles last taken. They approach what was last learned without a step.
    [[nodiscard]] const control::ObservedMotors &motors() const { return used_; }

    [[nodiscard]] const control::WindingObserver &observer(std::size_t motor) const {
        return observer_[motor];
    }

    /// What can be relied on of a winding as warm as the air; its deviation is infinite if nothing.
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
    void pass_over(const Vector3 &current_A, std::uint32_t missed_periods) noexcept;
    void approach_constants(const control::ObservedMotor &known,
                            control::ObservedMotor &used) const noexcept;
    void approach(const Vector3 &theta_rad, const Vector3 &before_Ohm,
                  const Vector3 &mean_before_Ohm) noexcept;

    double period_s_;
    double max_rate_Ohm_per_s_; ///< of the resistances used, and of their deviations
    std::size_t whole_delay_;
    double delay_fraction_;
    std::array<control::WindingObserver, 3> observer_;
    std::array<device::MotorParameters, 3> motor_;
    control::ObservedMotors used_;
    std::array<bool, 3> begins_anew_{}; ///< its estimates have nothing to do with those before
    Vector3 transfer_offset_here_Ohm_{Vector3::Zero()}; ///< steps of the estimates that are left
    Vector3 transfer_offset_mean_Ohm_{Vector3::Zero()};

    std::array<device::DeviceCommand, kHistory> history_{};
    std::size_t newest_ = 0;
    std::size_t known_commands_ = 0; ///< so many ticks in a row were without a gap
    bool has_previous_ = false;      ///< the next two are of the last tick
    std::array<std::optional<control::DrivenInterval>, 3> interval_;
    Vector3 current_A_{Vector3::Zero()};
    Vector3 theta_rad_{Vector3::Zero()};
};

} // namespace springdrive::servo

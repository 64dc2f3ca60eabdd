// How warm a winding is at the least and at the most, and what R̂ it can therefore bear.
//
// The device has no thermometer. But two bounds follow from the measured current alone, because the
// thermal network of winding_temperature.h never answers more heat or warmer air by less warmth:
//
//   least     starts in the coldest air, heated by no more than |i|² at least was over each tick,
//             times the least R(T, θ) at this very estimate
//   greatest  starts in the warmest air, heated by as much as |i|² at most was, times the greatest
//             R(T, θ) at this very estimate
//
// A sag of R below R̂ (7) makes the current grow as e^(|dR|t/L). So R̂ is held below the least R of
// any commutator angle at the least temperature. Whoever tunes R̂ on a hot motor gets the benefit
// of the heat that was surely there, and loses it at the pace at which it leaves.
//
// The bounds are as true as the device file and the measured current, which between two ticks runs
// monotonically from one reading to the other, as behind a held e_W it does; and the servo must
// not start on motors hotter than the warmest air, left so by an earlier run.
#pragma once

#include "device/core/motor/motor.h"
#include "device/core/motor/winding_temperature.h"

#include <cstdint>

namespace springdrive::device {

/// Air in which the device is meant to work: from a laboratory after a weekend without heating to
/// one on a summer's day. A colder one would have R below what the guard allows; 15 °C against
/// 25 °C costs 0.085 Ω of an RE 25's R̂.
inline constexpr double kColdestAir_C = 15.0;
inline constexpr double kWarmestAir_C = 35.0;

/// The least dR that is given to a motor of which nothing is known but that its windings are no
/// colder than that: R at 25 °C less the R̂ allowed then [Ω].
[[nodiscard]] double least_cold_residual_Ohm(const MotorParameters &motor,
                                             const AmplifierParameters &amplifier);

/// For one motor. RT-safe after construction.
class WindingGuard {
public:
    /// @param greatest_cancelled_Ohm  the largest R̂ that the amplifier can be set to
    /// @param period_s                T, how long each `update` lasts
    WindingGuard(const MotorParameters &motor, double greatest_cancelled_Ohm, double period_s);

    /// What is known stays. RT-safe.
    void set_period(double period_s) noexcept;

    /// One period later, with the current measured now. One that is not finite is unknown: it
    /// heats nothing at the least, and at the most as the amplifier's peak current would.
    ///
    /// Periods that were missed before count as well, each with what the current was at most; a
    /// winding may have cooled meanwhile to what the coldest air makes of it.
    void update(double current_A, std::uint32_t missed_periods = 0) noexcept;

    /// The largest R̂ that leaves a net resistance at every commutator angle, a share of
    /// kLeastResidualShare of R. That share also covers what a winding cools by while a command is
    /// under way: even at its hottest it takes more than a tenth of a second to lose as much.
    [[nodiscard]] double greatest_cancelled_Ohm() const noexcept;

    [[nodiscard]] double least_C() const { return least_.winding_C(); }
    [[nodiscard]] double greatest_C() const { return greatest_.winding_C(); }

private:
    /// So many periods take some microseconds; and the greatest is what it is after so many.
    static constexpr std::uint32_t kMostAtOnce = 100;
    static constexpr std::uint32_t kMostOwed = 1'000'000;

    void cool_through(std::uint32_t missed_periods) noexcept;
    void heat_through(std::uint32_t missed_periods, double most_A) noexcept;

    MotorParameters motor_;
    double amplifier_limit_Ohm_;
    WindingTemperature coldest_; ///< as the least began
    WindingTemperature least_;
    WindingTemperature greatest_;
    double current_A_ = 0.0; ///< at the last update
    std::uint32_t owed_ = 0; ///< missed periods that the greatest has not gone through yet
    double owed_most_A_ = 0.0;
};

} // namespace springdrive::device

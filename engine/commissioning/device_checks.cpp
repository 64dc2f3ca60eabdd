#include "engine/commissioning/self_test.h"

#include "base/assertions.h"
#include "base/degrees.h"
#include "device/core/motor/winding_heat.h"
#include "device/core/phantom/kinematics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace springdrive::commissioning {

namespace {

using device::ChannelPulse;

/// Findings are those of voltages above the brushes', by this factor: a winding is open where it
/// draws less than a quarter of the current that its R would let through.
constexpr double kJudgedBrushes = 1.5;

/// By which R may be off before it is named, in place of its ripple.
constexpr double kResistanceDeviations = 3.0;

class WindingJudge {
public:
    WindingJudge(const device::DeviceDescription &device, std::span<const PulseRound> rounds)
        : device_(device), rounds_(rounds) {
        double highest_V = 0.0;
        for (const PulseRound &round : rounds) {
            highest_V = std::max(highest_V, round.order.voltage_V);
        }
        for (std::size_t i = 0; i < 3; ++i) {
            judged_V_[i] =
                std::min(highest_V, kJudgedBrushes * device.motor[i].max_brush_voltage_V);
            for (const PulseRound &round : rounds) {
                judged_[i] += is_judged(round, i) ? 1 : 0;
            }
        }
    }

    WindingReport report() {
        for (std::size_t i = 0; i < 3; ++i) {
            measure(i);
            take_boards_findings(i);
        }
        const std::array<bool, 3> has_other_gain = other_gains();
        for (std::size_t i = 0; i < 3; ++i) {
            judge(i, has_other_gain[i]);
        }
        return std::move(report_);
    }

private:
    void measure(std::size_t i) {
        std::vector<PulseLevel> levels;
        for (const PulseRound &round : rounds_) {
            const ChannelPulse &pulse = round.result.channel[i];
            if (round.result.state == device::PulseState::completed &&
                std::isfinite(pulse.resistance_Ohm) && std::isfinite(pulse.inductance_H)) {
                levels.push_back({round.order.voltage_V,
                                  round.order.voltage_V / pulse.resistance_Ohm,
                                  pulse.inductance_H / pulse.resistance_Ohm, emf_V(i, round)});
            }
        }
        const PulseFit fit = fit_pulses(device_.motor[i], levels);
        report_.motor[i] = {fit.resistance_Ohm, fit.resistance_deviation_Ohm,
                            fit.inductance_H,   fit.inductance_deviation_H,
                            fit.brush_V,        fit.brush_deviation_V,
                            fit.curve,          times(i, &ChannelPulse::has_reversed_sensor) > 0};
    }

    /// At the change of sign, from whence the rotor goes as far again as before, to its rest. By
    /// its size: an encoder may be reversed.
    [[nodiscard]] double emf_V(std::size_t i, const PulseRound &round) const {
        return device_.motor[i].torque_constant_Nm_per_A * device_.rad_per_count() *
               std::abs(round.result.channel[i].moved_counts[i]) / round.order.duration_s;
    }

    /// Brushes may take nearly all of a lower voltage.
    [[nodiscard]] bool is_judged(const PulseRound &round, std::size_t i) const {
        return round.order.voltage_V >= judged_V_[i];
    }

    [[nodiscard]] std::ptrdiff_t times(std::size_t i, bool ChannelPulse::*finding) const {
        return std::ranges::count_if(rounds_, [&](const PulseRound &round) {
            return is_judged(round, i) && round.result.channel[i].*finding;
        });
    }

    /// "in 1 of 4 pulses: ", for what comes and goes.
    [[nodiscard]] std::string how_often(std::ptrdiff_t count, std::size_t i) const {
        return count == judged_[i] ? "" : fmt::format("in {} of {} pulses: ", count, judged_[i]);
    }

    void take_boards_findings(std::size_t i) {
        const std::size_t number = i + 1;
        if (times(i, &ChannelPulse::is_at_limit) > 0) {
            add(Problem::test_aborted, i,
                fmt::format("the pulses on motor {} ended at a limit of the board's: too much "
                            "current or motion",
                            number),
                "hold the device still; if it was, look for a shorted winding");
        }
        const std::ptrdiff_t crossed = times(i, &ChannelPulse::has_crossed_sensor);
        const std::ptrdiff_t open = times(i, &ChannelPulse::is_open);
        if (crossed > 0) {
            add(Problem::crossed_sensors, i,
                how_often(crossed, i) +
                    fmt::format("a voltage on motor {} shows as current in another channel",
                                number),
                "exchange the leads of the two motors, or of their current sensors");
        } else if (open > 0) {
            add(Problem::open_winding, i,
                how_often(open, i) + fmt::format("motor {} draws hardly any current", number),
                "look at its plug, its leads and its brushes");
        }
        if (const std::ptrdiff_t count = times(i, &ChannelPulse::has_reversed_sensor); count > 0) {
            add(Problem::reversed_sensor, i,
                how_often(count, i) +
                    fmt::format("the current sensor of motor {} counts against the voltage",
                                number),
                "exchange the sensor's leads: the amplifier would add R-hat instead of cancelling "
                "it");
        }
        if (2 * times(i, &ChannelPulse::has_crossed_encoder) > judged_[i]) {
            add(Problem::crossed_encoders, i,
                fmt::format("a voltage on motor {} turns the encoder of another one more than its "
                            "own",
                            number),
                "exchange the plugs of the two encoders, or of the two motors");
        } else if (2 * times(i, &ChannelPulse::has_reversed_encoder) > judged_[i]) {
            add(Problem::reversed_encoder, i,
                fmt::format("encoder {} counts down where its motor's voltage is positive", number),
                "exchange the motor's leads or the encoder's channels, or set the encoder's sign "
                "in "
                "the board's calibration");
        }
    }

    /// L by the file's, less 1.
    [[nodiscard]] double excess(std::size_t i) const {
        return report_.motor[i].inductance_H / device_.motor[i].inductance_H - 1.0;
    }

    /// By which L may be off before it is named.
    [[nodiscard]] double tolerance(std::size_t i) const {
        return std::max(kGainTolerance, kGainDeviations * report_.motor[i].inductance_deviation_H /
                                            device_.motor[i].inductance_H);
    }

    /// Another L at the same R. If R deviates alike, it is the sensor that does.
    [[nodiscard]] bool has_other_winding(std::size_t i) const {
        const double resistance_share =
            report_.motor[i].resistance_Ohm / device_.motor[i].resistance_Ohm;
        return std::abs(excess(i)) > kInductanceTolerance &&
               std::abs(resistance_share / (1.0 + excess(i)) - 1.0) > 0.5 * kInductanceTolerance;
    }

    [[nodiscard]] bool is_comparable(std::size_t i) const {
        return report_.motor[i].is_measured() && !has_other_winding(i);
    }

    /// By which L of a channel exceeds the mean of the others, each by the file's.
    [[nodiscard]] double against_others(std::size_t i) const {
        double sum = 0.0;
        int others = 0;
        for (std::size_t j = 0; j < 3; ++j) {
            if (j != i && is_comparable(j)) {
                sum += excess(j);
                ++others;
            }
        }
        return others > 0 ? (1.0 + excess(i)) / (1.0 + sum / others) - 1.0 : 0.0;
    }

    /// The odd one of three; or both others, if that one has the file's L and they have not.
    [[nodiscard]] std::array<bool, 3> other_gains() const {
        std::array<bool, 3> named{};
        std::size_t odd = 3;
        for (std::size_t i = 0; i < 3; ++i) {
            if (is_comparable(i) && std::abs(against_others(i)) > tolerance(i) &&
                (odd == 3 || std::abs(against_others(i)) > std::abs(against_others(odd)))) {
                odd = i;
            }
        }
        if (odd == 3) {
            return named;
        }
        named[odd] = std::abs(excess(odd)) > tolerance(odd);
        for (std::size_t i = 0; i < 3; ++i) {
            named[i] = named[i] || (i != odd && !named[odd] && is_comparable(i) &&
                                    std::abs(excess(i)) > tolerance(i));
        }
        return named;
    }

    void judge(std::size_t i, bool has_other_gain) {
        const WindingFigures &motor = report_.motor[i];
        if (!motor.is_measured()) {
            if (report_.findings.empty()) {
                add(Problem::test_aborted, i,
                    fmt::format("R of motor {} could not be measured", i + 1),
                    "hold the device still, and test again");
            }
            return;
        }
        double gain = 1.0;
        if (has_other_winding(i)) {
            add(Problem::wrong_inductance, i,
                fmt::format("L of motor {} is {:.3f} mH, {:+.0f} % from the file's {:.3f} mH",
                            i + 1, 1e3 * motor.inductance_H, 100.0 * excess(i),
                            1e3 * device_.motor[i].inductance_H),
                "is it the motor of the device file? shorted turns lower L, too");
        } else if (has_other_gain) {
            gain = 1.0 + excess(i);
            add(Problem::wrong_sensor_gain, i,
                fmt::format("the current sensor of motor {} has a gain {:+.0f} % from that of the "
                            "others, or the motor another L: it appears as {:.3f} mH",
                            i + 1, 100.0 * (1.0 / gain - 1.0), 1e3 * motor.inductance_H),
                "calibrate its gain against a meter in series: an error of the gain is one of dR");
        }
        judge_resistance(i, motor.resistance_Ohm / gain,
                         kResistanceDeviations * motor.resistance_deviation_Ohm / gain);
    }

    void judge_resistance(std::size_t i, double resistance_Ohm, double error_Ohm) {
        const device::MotorParameters &motor = device_.motor[i];
        const double cold = 1.0 - motor.resistance_rise_per_K *
                                      (device::kReferenceTemperature_C - device::kColdestAir_C);
        const double warm = 1.0 + motor.resistance_rise_per_K *
                                      (device::kWarmestAir_C - device::kReferenceTemperature_C);
        const double tolerance =
            device_.resistance_tolerance(i) +
            std::max(motor.commutation_ripple, error_Ohm / motor.resistance_Ohm);
        const double least_Ohm = motor.resistance_Ohm * (1.0 - tolerance) * cold;
        const double largest_Ohm = motor.resistance_Ohm * (1.0 + tolerance) * warm;
        if (resistance_Ohm < least_Ohm || resistance_Ohm > largest_Ohm) {
            add(Problem::wrong_resistance, i,
                fmt::format(
                    "R of motor {} is {:.3f} Ohm, {:+.0f} % from the file's {:.3f} Ohm; "
                    "tolerance and air from {:.0f} to {:.0f} degrees allow {:.3f} to {:.3f}",
                    i + 1, resistance_Ohm, 100.0 * (resistance_Ohm / motor.resistance_Ohm - 1.0),
                    motor.resistance_Ohm, device::kColdestAir_C, device::kWarmestAir_C, least_Ohm,
                    largest_Ohm),
                resistance_Ohm > largest_Ohm
                    ? "let warm motors rest for half an hour; look at plug and brushes; or is it "
                      "another motor?"
                    : "is it the motor of the device file? look for shorted turns");
        }
    }

    void add(Problem problem, std::size_t channel, std::string what, std::string remedy) {
        report_.findings.push_back({problem, channel, std::move(what), std::move(remedy)});
    }

    const device::DeviceDescription &device_;
    std::span<const PulseRound> rounds_;
    std::array<double, 3> judged_V_{};
    std::array<std::ptrdiff_t, 3> judged_{};
    WindingReport report_;
};

} // namespace

WindingReport check_windings(const device::DeviceDescription &device,
                             std::span<const PulseRound> rounds) {
    SPRINGDRIVE_ASSERT(!rounds.empty());
    return WindingJudge(device, rounds).report();
}

namespace {

/// A window is over when a motor has turned so far that counts' rounding and the current's noise
/// are small, or after a while: a hand may move slowly.
constexpr double kMinWindow_s = 0.05;
constexpr double kMaxWindow_s = 1.0;
constexpr double kTurnedInWindow_rad = 0.3;
/// Between two measurements: after more, a window begins anew.
constexpr double kMaxGap_s = 0.02;
/// A motor that turned less has not been moved: 10° of a joint.
constexpr double kMinTurned_rad = 2.0;
/// In a window; less is noise, of which sums grow without end: 1 mA in the longest is 0.09 rad.
constexpr double kMinInWindow_rad = 0.15;
/// Over which currents are averaged before tanh: noise of 3 mA is not small against i_b of 10 mA.
constexpr double kBlock_s = 8e-3;
/// Of an i_b by the pulses.
constexpr double kAllowedChi2 = 9.0;
constexpr double kAgreeing = 0.8; ///< squared correlation
constexpr double kDiffering = 0.5;

double in_degrees(double angle_rad) { return angle_rad / kRadiansPerDegree; }

constexpr std::array<const char *, 3> kMoves{
    "turn the base (joint 1) to its left and right stop",
    "push the tip away as far as it goes, and pull it in as far as it goes",
    "tilt the forearm (joint 3) back to its stop"};

} // namespace

MotionCheck::MotionCheck(const device::DeviceDescription &device) : device_(device) {}

void MotionCheck::set_windings(const WindingReport &windings) {
    windings_ = windings;
    for (Eigen::Index motor = 0; motor < 3; ++motor) {
        const auto i = static_cast<std::size_t>(motor);
        const WindingFigures &measured = windings.motor[i];
        const double sign = measured.has_reversed_sensor ? 1.0 : -1.0;
        turned_per_Vs_[motor] = sign / device_.motor[i].torque_constant_Nm_per_A;
        for (Eigen::Index curve = 0; curve < turned_rad_.cols(); ++curve) {
            const BrushCurve &own = measured.curve[static_cast<std::size_t>(curve)];
            resistance_Ohm_(motor, curve) = own.resistance_Ohm;
            brush_V_(motor, curve) = own.voltage_V;
            brush_A_(motor, curve) = own.brush_A;
            chi2_(motor, curve) = own.chi2;
        }
    }
}

Vector3 MotionCheck::joints_rad(const device::Measurement &measured) const {
    const Vector3 theta_rad = device_.rad_per_count() *
                              Vector3(measured.counts[0], measured.counts[1], measured.counts[2]);
    return device::joint_from_motor(device_.geometry, theta_rad);
}

void MotionCheck::take(const device::Measurement &measured) {
    const Vector3 q_rad = joints_rad(measured);
    const Vector3 passed_rad(q_rad[0], q_rad[2] - q_rad[1], q_rad[2]);
    if (!has_measurement_) {
        has_measurement_ = true;
        lowest_rad_ = highest_rad_ = passed_rad;
        window_.first_counts = measured.counts;
        last_ = measured;
        return;
    }
    lowest_rad_ = lowest_rad_.cwiseMin(passed_rad);
    highest_rad_ = highest_rad_.cwiseMax(passed_rad);
    const double passed_s = measured.time_s - last_.time_s;
    if (!(passed_s >= 0.0 && passed_s <= kMaxGap_s) || !measured.current_A.allFinite()) {
        begin_window(measured);
    } else {
        window_.duration_s += passed_s;
        window_.block_s += passed_s;
        window_.block_As += passed_s * (0.5 * (last_.current_A + measured.current_A) - offset_A_);
        if (window_.block_s >= kBlock_s) {
            close_block();
        }
        if (is_window_over(measured)) {
            close_window(measured);
        }
    }
    last_ = measured;
}

double MotionCheck::counted_rad(const device::Measurement &measured, std::size_t motor) const {
    const auto now = static_cast<double>(measured.counts[motor]);
    return device_.rad_per_count() * (now - static_cast<double>(window_.first_counts[motor]));
}

bool MotionCheck::is_window_over(const device::Measurement &measured) const {
    if (window_.duration_s < kMinWindow_s || window_.duration_s >= kMaxWindow_s) {
        return window_.duration_s >= kMaxWindow_s;
    }
    return std::abs(counted_rad(measured, 0)) >= kTurnedInWindow_rad ||
           std::abs(counted_rad(measured, 1)) >= kTurnedInWindow_rad ||
           std::abs(counted_rad(measured, 2)) >= kTurnedInWindow_rad;
}

void MotionCheck::begin_window(const device::Measurement &measured) {
    window_ = Window();
    window_.first_counts = measured.counts;
}

void MotionCheck::close_block() {
    if (window_.block_s > 0.0) {
        const Eigen::Array3d current_A = window_.block_As / window_.block_s;
        const Curves voltage_V = resistance_Ohm_.colwise() * current_A +
                                 brush_V_ * (brush_A_.inverse().colwise() * current_A).tanh();
        window_.turned_rad += window_.block_s * (voltage_V.colwise() * turned_per_Vs_.array());
    }
    window_.block_s = 0.0;
    window_.block_As.setZero();
}

void MotionCheck::close_window(const device::Measurement &measured) {
    close_block();
    const Curves &turned_rad = window_.turned_rad;
    turned_squared_ += turned_rad.square();
    turned_rad_ += (turned_rad.abs() > kMinInWindow_rad).select(turned_rad.abs(), 0.0);
    for (std::size_t i = 0; i < 3; ++i) {
        const auto encoder = static_cast<Eigen::Index>(i);
        const double counted = counted_rad(measured, i);
        turned_with_counts_[i] += counted * turned_rad;
        counts_squared_[encoder] += counted * counted;
        if (std::abs(counted) > kMinInWindow_rad) {
            counted_rad_[encoder] += std::abs(counted);
            ++windows_[i];
        }
    }
    begin_window(measured);
}

std::array<StopFigures, 3> MotionCheck::stops() const {
    const device::JointLimits &limits = device_.joint_limits;
    return {{{"joint 1", lowest_rad_[0], highest_rad_[0], limits.min_rad[0], limits.max_rad[0]},
             {"the angle between the links", lowest_rad_[1], highest_rad_[1],
              limits.min_q3_minus_q2_rad, limits.max_q3_minus_q2_rad},
             {"joint 3", lowest_rad_[2], highest_rad_[2], limits.min_rad[2], limits.max_rad[2],
              false}}};
}

namespace {

/// The distance between two stops does not depend on the zero; of one stop alone only its place
/// tells whether it was reached.
bool is_reached(const StopFigures &stop) {
    return stop.has_highest
               ? stop.highest_rad - stop.lowest_rad >=
                     stop.file_highest_rad - stop.file_lowest_rad - 2.0 * kStopTolerance_rad
               : stop.lowest_rad <= stop.file_lowest_rad + kStopTolerance_rad;
}

} // namespace

std::string MotionCheck::missing() const {
    const auto all = stops();
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (!has_measurement_ || !is_reached(all[i])) {
            return kMoves[i];
        }
    }
    return "";
}

double MotionCheck::share() const {
    const auto all = stops();
    return static_cast<double>(std::ranges::count_if(all, is_reached)) / 3.0;
}

namespace {

/// Judges the sums of a MotionCheck.
class MotionJudge {
public:
    MotionJudge(const WindingReport &windings, MotionReport &report)
        : windings_(windings), report_(report) {}

    void judge_motor(std::size_t i, double agreement, bool is_crossed) {
        const MotionFigures &motor = report_.motor[i];
        const std::size_t number = i + 1;
        const bool counts = motor.turned_by_counts_rad >= kMinTurned_rad;
        if (!counts && motor.turned_at_least_rad < kMinTurned_rad) {
            add(Problem::seized_joint, i,
                fmt::format(
                    "joint {} did not move: neither its encoder nor its winding saw it turn",
                    number),
                "move it; if it resists, look for a jammed cable or gear");
        } else if (!counts) {
            add(Problem::dead_encoder, i,
                fmt::format("encoder {} counts nothing, though the winding says that its motor "
                            "turned by {:.1f} turns",
                            number, motor.turned_by_current_rad / (2.0 * M_PI)),
                "look at the encoder's plug and supply");
        } else if (motor.turned_at_most_rad < kMinTurned_rad) {
            if (!has_found(Problem::open_winding, i)) {
                add(Problem::open_winding, i,
                    fmt::format("motor {} turned by {:.1f} turns without a current in its braking "
                                "winding",
                                number, motor.turned_by_counts_rad / (2.0 * M_PI)),
                    "look at its leads and its current sensor");
            }
        } else if (has_found(Problem::crossed_sensors, i)) {
            return; // the winding that was seen is another motor's
        } else if (agreement < kDiffering) {
            judge_disagreement(i, is_crossed);
        } else {
            judge_counts(i);
        }
    }

    /// Without a zero, only distances between stops are known.
    void judge_stop(const StopFigures &stop, std::size_t channel, bool is_zeroed) {
        const double below_rad = stop.lowest_rad - stop.file_lowest_rad;
        const double above_rad = stop.highest_rad - stop.file_highest_rad;
        if (!stop.has_highest) {
            if (is_zeroed && std::abs(below_rad) > kStopTolerance_rad) {
                add(below_rad > 0.0 ? Problem::stops_not_reached : Problem::wrong_zero, channel,
                    fmt::format("{} went to {:.1f} degrees, but its stop is at {:.1f}", stop.name,
                                in_degrees(stop.lowest_rad), in_degrees(stop.file_lowest_rad)),
                    below_rad > 0.0 ? "move it to its stop; if it is there, zero the device anew"
                                    : "zero the device anew, in its zero pose");
            }
            return;
        }
        const double range_rad = stop.highest_rad - stop.lowest_rad;
        const double file_rad = stop.file_highest_rad - stop.file_lowest_rad;
        const double offset_rad = 0.5 * (below_rad + above_rad);
        if (!is_reached(stop)) {
            add(Problem::stops_not_reached, channel,
                fmt::format("{} was moved through {:.1f} of {:.1f} degrees", stop.name,
                            in_degrees(range_rad), in_degrees(file_rad)),
                "move it to both of its stops; if it was, counts are lost");
        } else if (range_rad > file_rad + 2.0 * kStopTolerance_rad) {
            add(Problem::wrong_counts, channel,
                fmt::format("{} moved through {:.1f} degrees, but its stops are {:.1f} apart",
                            stop.name, in_degrees(range_rad), in_degrees(file_rad)),
                "is it the machine of the device file, with its transmission ratios and counts a "
                "turn?");
        } else if (is_zeroed && std::abs(offset_rad) > kStopTolerance_rad) {
            add(Problem::wrong_zero, channel,
                fmt::format("the zero of {} is off by {:+.1f} degrees, by both of its stops",
                            stop.name, in_degrees(offset_rad)),
                "zero the device anew, in its zero pose: upper arm level, forearm hanging");
        }
    }

    /// What all three encoders seem to have in common is none of theirs.
    void judge_voltage() {
        std::array<double, 3> counted{};
        for (std::size_t i = 0; i < 3; ++i) {
            counted[i] = report_.motor[i].counts_per_turned;
        }
        const auto [least, most] = std::ranges::minmax(counted);
        const double middle = 0.5 * (least + most);
        const bool are_alike = most - least < kCountsTolerance && middle > 0.0;
        if (!are_alike || std::abs(middle - 1.0) <= kCountsTolerance ||
            std::ranges::count(report_.findings, Problem::wrong_counts, &Finding::problem) < 2) {
            return;
        }
        std::erase_if(report_.findings, [](const Finding &finding) {
            return finding.problem == Problem::wrong_counts;
        });
        report_.findings.push_back(
            {Problem::wrong_voltage, std::nullopt,
             fmt::format("all three motors seem to turn by {:.0f} % of what is counted: R of the "
                         "pulses is wrong on all channels",
                         100.0 / middle),
             "is the supply what the board takes it for? are all motors and encoders those of the "
             "device file?"});
    }

    void add(Problem problem, std::size_t channel, std::string what, std::string remedy) {
        report_.findings.push_back({problem, channel, std::move(what), std::move(remedy)});
    }

private:
    [[nodiscard]] bool has_found(Problem problem, std::size_t channel) const {
        const auto is_it = [&](const Finding &finding) {
            return finding.problem == problem && finding.channel == channel;
        };
        return std::ranges::any_of(windings_.findings, is_it) ||
               std::ranges::any_of(report_.findings, is_it);
    }

    void judge_disagreement(std::size_t i, bool is_crossed) {
        if (is_crossed) {
            add(Problem::crossed_encoders, i,
                fmt::format("the winding of motor {} turns with the encoder of another one", i + 1),
                "exchange the plugs of the two encoders, or of the two motors");
        } else {
            add(Problem::wrong_counts, i,
                fmt::format(
                    "encoder {} counts {:.1f} turns where its winding saw {:.1f}, and not at "
                    "the same times",
                    i + 1, report_.motor[i].turned_by_counts_rad / (2.0 * M_PI),
                    report_.motor[i].turned_by_current_rad / (2.0 * M_PI)),
                "look at the encoder's cable, its supply and its disc");
        }
    }

    void judge_counts(std::size_t i) {
        const double counted = report_.motor[i].counts_per_turned;
        if (counted < 0.0) {
            add(Problem::reversed_encoder, i,
                fmt::format("encoder {} counts down where its winding says up", i + 1),
                "exchange the motor's leads or the encoder's channels, or set the encoder's sign "
                "in "
                "the board's calibration");
        } else if (std::abs(counted - 1.0) >
                   std::max(kCountsTolerance,
                            kCountsDeviations * report_.motor[i].counts_deviation)) {
            add(Problem::wrong_counts, i,
                fmt::format("encoder {} counts {:.0f} % of what its motor turned by its back-EMF",
                            i + 1, 100.0 * counted),
                counted < 1.0 ? "counts are lost: look at the encoder's cable and disc, and at a "
                                "coupling that slips"
                              : "is it the encoder and the motor of the device file?");
        }
    }

    const WindingReport &windings_;
    MotionReport &report_;
};

} // namespace

/// Squared correlation of what a motor's current and an encoder say, by the i_b by which it is
/// best.
double MotionCheck::agreement(std::size_t motor, std::size_t encoder) const {
    double best = 0.0;
    for (Eigen::Index curve = 0; curve < turned_rad_.cols(); ++curve) {
        const auto row = static_cast<Eigen::Index>(motor);
        const double product =
            turned_squared_(row, curve) * counts_squared_[static_cast<Eigen::Index>(encoder)];
        const double common = turned_with_counts_[encoder](row, curve);
        best = product > 0.0 ? std::max(best, common * common / product) : best;
    }
    return best;
}

/// By each i_b, counts are κ times what the currents say, and what is left is S. Like pulses, S
/// weighs each i_b: what ripples leave is shared by many windows, by a factor as in BrushFit.
MotionFigures MotionCheck::figures(std::size_t i) const {
    constexpr double kShared = 3.0;
    const auto motor = static_cast<Eigen::Index>(i);
    const auto squared = turned_squared_.row(motor);
    const Eigen::Array<double, 1, kBrushCurves> common = turned_with_counts_[i].row(motor);
    const Eigen::Array<double, 1, kBrushCurves> ratio =
        (squared > 0.0).select(common / squared.max(1e-300), 0.0);
    const Eigen::Array<double, 1, kBrushCurves> left =
        (counts_squared_[motor] - ratio * common).max(0.0);
    const double left_of_window =
        std::max(kShared * kShared * left.minCoeff() / std::max(1, windows_[i] - 1), 1e-12);
    const Eigen::Array<double, 1, kBrushCurves> chi2 =
        chi2_.row(motor) + (left - left.minCoeff()) / left_of_window;
    const Eigen::Array<double, 1, kBrushCurves> weight = (-0.5 * (chi2 - chi2.minCoeff())).exp();
    const double sum = weight.sum();
    MotionFigures figures;
    figures.turned_by_counts_rad = counted_rad_[motor];
    figures.turned_by_current_rad = (weight * turned_rad_.row(motor)).sum() / sum;
    figures.counts_per_turned = (weight * ratio).sum() / sum;
    const double variance =
        (weight * (ratio.square() + left_of_window / squared.max(1e-300))).sum() / sum -
        figures.counts_per_turned * figures.counts_per_turned;
    figures.counts_deviation = std::sqrt(std::max(0.0, variance));
    const auto is_allowed = chi2_.row(motor) < kAllowedChi2;
    figures.turned_at_least_rad = is_allowed.select(turned_rad_.row(motor), 1e9).minCoeff();
    figures.turned_at_most_rad = is_allowed.select(turned_rad_.row(motor), 0.0).maxCoeff();
    return figures;
}

MotionReport MotionCheck::report(bool is_zeroed) const {
    MotionReport report;
    report.stops = stops();
    MotionJudge judge(windings_, report);
    for (std::size_t i = 0; i < 3; ++i) {
        report.motor[i] = figures(i);
        bool is_crossed = false;
        for (std::size_t other = 0; other < 3; ++other) {
            is_crossed = is_crossed || (other != i && agreement(i, other) > kAgreeing);
        }
        judge.judge_motor(i, agreement(i, i), is_crossed);
    }
    judge.judge_voltage();
    if (report.findings.empty()) { // angles say nothing where counts are wrong
        for (std::size_t i = 0; i < report.stops.size(); ++i) {
            judge.judge_stop(report.stops[i], i, is_zeroed);
        }
    }
    return report;
}

} // namespace springdrive::commissioning

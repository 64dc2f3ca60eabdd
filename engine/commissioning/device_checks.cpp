#include "engine/commissioning/self_test.h"

#include "base/assertions.h"
#include "base/degrees.h"
#include "device/core/motor/winding_heat.h"
#include "device/core/phantom/kinematics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace springdrive::commissioning {

namespace {

using device::ChannelPulse;

struct MeanAndDeviation {
    double mean = 0.0;
    double deviation = 0.0; ///< of the mean
};

/// Of those that were measured; NaN without any.
template <class Member>
MeanAndDeviation mean_of(std::span<const device::PulseResult> results, std::size_t channel,
                         Member member) {
    std::vector<double> values;
    for (const device::PulseResult &result : results) {
        const double value = result.channel[channel].*member;
        if (result.state == device::PulseState::completed && std::isfinite(value)) {
            values.push_back(value);
        }
    }
    const auto count = static_cast<double>(values.size());
    const double mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
    double squares = 0.0;
    for (const double value : values) {
        squares += (value - mean) * (value - mean);
    }
    return {mean, values.size() > 1 ? std::sqrt(squares / (count - 1.0) / count) : 0.0};
}

class WindingJudge {
public:
    WindingJudge(const device::DeviceDescription &device,
                 std::span<const device::PulseResult> results)
        : device_(device), results_(results) {}

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
        WindingFigures &motor = report_.motor[i];
        const auto resistance = mean_of(results_, i, &ChannelPulse::resistance_Ohm);
        const auto inductance = mean_of(results_, i, &ChannelPulse::inductance_H);
        motor.resistance_Ohm = resistance.mean;
        motor.resistance_deviation_Ohm = resistance.deviation;
        motor.inductance_H = inductance.mean;
        motor.inductance_deviation_H = inductance.deviation;
        motor.has_reversed_sensor = times(i, &ChannelPulse::has_reversed_sensor) > 0;
    }

    [[nodiscard]] std::ptrdiff_t times(std::size_t i, bool ChannelPulse::*finding) const {
        return std::ranges::count_if(results_, [&](const device::PulseResult &result) {
            return result.channel[i].*finding;
        });
    }

    /// "in 1 of 4 pulses: ", for what comes and goes.
    [[nodiscard]] std::string how_often(std::ptrdiff_t count) const {
        return count == std::ssize(results_)
                   ? ""
                   : fmt::format("in {} of {} pulses: ", count, results_.size());
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
                how_often(crossed) +
                    fmt::format("a voltage on motor {} shows as current in another channel",
                                number),
                "exchange the leads of the two motors, or of their current sensors");
        } else if (open > 0) {
            add(Problem::open_winding, i,
                how_often(open) + fmt::format("motor {} draws hardly any current", number),
                "look at its plug, its leads and its brushes");
        }
        if (const std::ptrdiff_t count = times(i, &ChannelPulse::has_reversed_sensor); count > 0) {
            add(Problem::reversed_sensor, i,
                how_often(count) +
                    fmt::format("the current sensor of motor {} counts against the voltage",
                                number),
                "exchange the sensor's leads: the amplifier would add R-hat instead of cancelling "
                "it");
        }
        if (2 * times(i, &ChannelPulse::has_crossed_encoder) > std::ssize(results_)) {
            add(Problem::crossed_encoders, i,
                fmt::format("a voltage on motor {} turns the encoder of another one more than its "
                            "own",
                            number),
                "exchange the plugs of the two encoders, or of the two motors");
        } else if (2 * times(i, &ChannelPulse::has_reversed_encoder) > std::ssize(results_)) {
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
        judge_resistance(i, motor.resistance_Ohm / gain);
    }

    void judge_resistance(std::size_t i, double resistance_Ohm) {
        const device::MotorParameters &motor = device_.motor[i];
        const double cold = 1.0 - motor.resistance_rise_per_K *
                                      (device::kReferenceTemperature_C - device::kColdestAir_C);
        const double warm = 1.0 + motor.resistance_rise_per_K *
                                      (device::kWarmestAir_C - device::kReferenceTemperature_C);
        const double tolerance = device_.resistance_tolerance(i) + motor.commutation_ripple;
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
    std::span<const device::PulseResult> results_;
    WindingReport report_;
};

} // namespace

WindingReport check_windings(const device::DeviceDescription &device,
                             std::span<const device::PulseResult> results) {
    SPRINGDRIVE_ASSERT(!results.empty());
    return WindingJudge(device, results).report();
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
constexpr double kAgreeing = 0.8; ///< squared correlation
constexpr double kDiffering = 0.5;

double in_degrees(double angle_rad) { return angle_rad / kRadiansPerDegree; }

constexpr std::array<const char *, 3> kMoves{
    "turn the base (joint 1) to its left and right stop",
    "push the tip away as far as it goes, and pull it in as far as it goes",
    "tilt the forearm (joint 3) back to its stop"};

} // namespace

MotionCheck::MotionCheck(const device::DeviceDescription &device) : device_(device) {}

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
        window_ = {0.0, Vector3::Zero(), measured.counts};
    } else {
        window_.duration_s += passed_s;
        window_.charge_As += passed_s * (0.5 * (last_.current_A + measured.current_A) - offset_A_);
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

void MotionCheck::close_window(const device::Measurement &measured) {
    for (Eigen::Index i = 0; i < 3; ++i) {
        const auto motor = static_cast<std::size_t>(i);
        const double counted = counted_rad(measured, motor);
        const double charge_As = window_.charge_As[i];
        const device::MotorParameters &file = device_.motor[motor];
        const double turned_rad =
            file.resistance_Ohm * std::abs(charge_As) / file.torque_constant_Nm_per_A;
        counts_squared_[i] += counted * counted;
        charges_squared_[i] += charge_As * charge_As;
        charges_with_counts_.col(i) += window_.charge_As * counted;
        counted_rad_[i] += std::abs(counted) > kMinInWindow_rad ? std::abs(counted) : 0.0;
        charged_As_[i] += turned_rad > kMinInWindow_rad ? std::abs(charge_As) : 0.0;
    }
    window_ = {0.0, Vector3::Zero(), measured.counts};
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
    MotionJudge(const device::DeviceDescription &device, const WindingReport &windings,
                MotionReport &report)
        : device_(device), windings_(windings), report_(report) {}

    /// Angle that a motor turned by a charge that its sensor saw.
    [[nodiscard]] double rad_per_As(std::size_t motor) const {
        const WindingFigures &measured = windings_.motor[motor];
        const double R_Ohm = std::isfinite(measured.resistance_Ohm)
                                 ? measured.resistance_Ohm
                                 : device_.motor[motor].resistance_Ohm;
        const double sign = measured.has_reversed_sensor ? 1.0 : -1.0;
        return sign * R_Ohm / device_.motor[motor].torque_constant_Nm_per_A;
    }

    void judge_motor(std::size_t i, double agreement, bool is_crossed) {
        const MotionFigures &motor = report_.motor[i];
        const std::size_t number = i + 1;
        const bool counts = motor.turned_by_counts_rad >= kMinTurned_rad;
        const bool turns = motor.turned_by_current_rad >= kMinTurned_rad;
        if (!counts && !turns) {
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
        } else if (!turns) {
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
        } else if (std::abs(counted - 1.0) > kCountsTolerance) {
            add(Problem::wrong_counts, i,
                fmt::format("encoder {} counts {:.0f} % of what its motor turned by its back-EMF",
                            i + 1, 100.0 * counted),
                counted < 1.0 ? "counts are lost: look at the encoder's cable and disc, and at a "
                                "coupling that slips"
                              : "is it the encoder and the motor of the device file?");
        }
    }

    const device::DeviceDescription &device_;
    const WindingReport &windings_;
    MotionReport &report_;
};

} // namespace

MotionReport MotionCheck::report(const WindingReport &windings, bool is_zeroed) const {
    MotionReport report;
    report.stops = stops();
    MotionJudge judge(device_, windings, report);
    for (std::size_t i = 0; i < 3; ++i) {
        const auto motor = static_cast<Eigen::Index>(i);
        const double rad_per_As = judge.rad_per_As(i);
        const double turned_squared = rad_per_As * rad_per_As * charges_squared_[motor];
        report.motor[i] = {counted_rad_[motor], std::abs(rad_per_As) * charged_As_[motor],
                           turned_squared > 0.0
                               ? rad_per_As * charges_with_counts_(motor, motor) / turned_squared
                               : 0.0};
        const auto agreement_with = [&](Eigen::Index encoder) {
            const double product = charges_squared_[motor] * counts_squared_[encoder];
            const double common = charges_with_counts_(motor, encoder);
            return product > 0.0 ? common * common / product : 0.0;
        };
        bool is_crossed = false;
        for (Eigen::Index other = 0; other < 3; ++other) {
            is_crossed = is_crossed || (other != motor && agreement_with(other) > kAgreeing);
        }
        judge.judge_motor(i, agreement_with(motor), is_crossed);
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

#include "engine/commissioning/winding_check.h"

#include "base/assertions.h"
#include "device/core/motor/winding_guard.h"

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

} // namespace springdrive::commissioning

#include "engine/commissioning/winding_check.h"

#include "base/assertions.h"
#include "device/core/motor/winding_guard.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace springdrive::commissioning {

namespace {

using device::ChannelPulse;

struct MeanAndDeviation {
    double mean = 0.0;
    double deviation = 0.0; ///< of the mean
};

template <class Member>
MeanAndDeviation mean_of(std::span<const device::PulseResult> results, std::size_t channel,
                         Member member) {
    const auto count = static_cast<double>(results.size());
    double sum = 0.0;
    for (const device::PulseResult &result : results) {
        sum += result.channel[channel].*member;
    }
    const double mean = sum / count;
    double squares = 0.0;
    for (const device::PulseResult &result : results) {
        squares += std::pow(result.channel[channel].*member - mean, 2.0);
    }
    return {mean, results.size() > 1 ? std::sqrt(squares / (count - 1.0) / count) : 0.0};
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
        for (std::size_t i = 0; i < 3; ++i) {
            judge(i);
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
        motor.has_reversed_sensor = is_usual(i, &ChannelPulse::has_reversed_sensor);
        is_measured_[i] = std::isfinite(motor.resistance_Ohm) && motor.resistance_Ohm > 0.0;
    }

    /// In most of the pulses.
    [[nodiscard]] bool is_usual(std::size_t i, bool ChannelPulse::*finding) const {
        const auto times = std::ranges::count_if(results_, [&](const device::PulseResult &result) {
            return result.channel[i].*finding;
        });
        return 2 * times > std::ssize(results_);
    }

    void take_boards_findings(std::size_t i) {
        const std::size_t number = i + 1;
        if (is_usual(i, &ChannelPulse::is_at_limit)) {
            add(Problem::test_aborted, i,
                fmt::format(
                    "the pulses on motor {} end at a limit of the board's: too much current "
                    "or motion",
                    number),
                "look for a shorted winding, or hold the device still");
        }
        if (is_usual(i, &ChannelPulse::has_crossed_sensor)) {
            add(Problem::crossed_sensors, i,
                fmt::format("a voltage on motor {} shows as current in another channel", number),
                "exchange the leads of the two motors, or of their current sensors");
        } else if (is_usual(i, &ChannelPulse::is_open)) {
            add(Problem::open_winding, i, fmt::format("motor {} draws hardly any current", number),
                "look at its plug, its leads and its brushes");
        }
        if (is_usual(i, &ChannelPulse::has_reversed_sensor)) {
            add(Problem::reversed_sensor, i,
                fmt::format("the current sensor of motor {} counts against the voltage", number),
                "exchange the sensor's leads: the amplifier would add R-hat instead of cancelling "
                "it");
        }
        if (is_usual(i, &ChannelPulse::has_crossed_encoder)) {
            add(Problem::crossed_encoders, i,
                fmt::format("a voltage on motor {} turns the encoder of another one more than its "
                            "own",
                            number),
                "exchange the plugs of the two encoders, or of the two motors");
        } else if (is_usual(i, &ChannelPulse::has_reversed_encoder)) {
            add(Problem::reversed_encoder, i,
                fmt::format("encoder {} counts down where its motor's voltage is positive", number),
                "exchange the motor's leads or the encoder's channels, or set the encoder's sign "
                "in "
                "the board's calibration");
        }
    }

    [[nodiscard]] double file_H(std::size_t i) const { return device_.motor[i].inductance_H; }

    /// Share by which L of a channel exceeds the mean of the others' that are measured.
    [[nodiscard]] double against_others(std::size_t i) const {
        double sum = 0.0;
        int others = 0;
        for (std::size_t j = 0; j < 3; ++j) {
            if (j != i && is_measured_[j] && !has_other_winding(j)) {
                sum += report_.motor[j].inductance_H / file_H(j);
                ++others;
            }
        }
        return others > 0 ? report_.motor[i].inductance_H / file_H(i) / (sum / others) - 1.0 : 0.0;
    }

    [[nodiscard]] bool has_other_winding(std::size_t i) const {
        return std::abs(report_.motor[i].inductance_H / file_H(i) - 1.0) > kInductanceTolerance;
    }

    /// The odd one of three: it differs from both others more than they differ from each other.
    [[nodiscard]] bool has_other_gain(std::size_t i) const {
        const double own = std::abs(against_others(i));
        if (has_other_winding(i) || own <= kSensorGainTolerance) {
            return false;
        }
        for (std::size_t j = 0; j < 3; ++j) {
            if (j != i && is_measured_[j] && !has_other_winding(j) &&
                std::abs(against_others(j)) > own) {
                return false;
            }
        }
        return true;
    }

    void judge(std::size_t i) {
        if (!is_measured_[i]) {
            return;
        }
        const WindingFigures &motor = report_.motor[i];
        const std::size_t number = i + 1;
        double gain = 1.0;
        if (has_other_winding(i)) {
            add(Problem::wrong_inductance, i,
                fmt::format("L of motor {} is {:.3f} mH, {:+.0f} % from the file's {:.3f} mH",
                            number, 1e3 * motor.inductance_H,
                            100.0 * (motor.inductance_H / file_H(i) - 1.0), 1e3 * file_H(i)),
                "is it the motor of the device file? shorted turns lower L, too");
        } else if (has_other_gain(i)) {
            gain = 1.0 / (1.0 + against_others(i));
            add(Problem::wrong_sensor_gain, i,
                fmt::format(
                    "the current sensor of motor {} shows {:+.0f} % against the two others: "
                    "L appears as {:.3f} mH",
                    number, 100.0 * (gain - 1.0), 1e3 * motor.inductance_H),
                "calibrate its gain against a meter in series: an error of the gain is one of dR");
        }
        judge_resistance(i, gain * motor.resistance_Ohm);
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
    std::array<bool, 3> is_measured_{};
    WindingReport report_;
};

} // namespace

WindingReport check_windings(const device::DeviceDescription &device,
                             std::span<const device::PulseResult> results) {
    SPRINGDRIVE_ASSERT(!results.empty());
    return WindingJudge(device, results).report();
}

} // namespace springdrive::commissioning

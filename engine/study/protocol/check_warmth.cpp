#include "device/core/motor/winding_temperature.h"
#include "engine/study/protocol/checks.h"
#include "engine/study/protocol/warm_up_trial.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace springdrive::study {

namespace {

/// Squares of the motors' currents while a stimulus is presented.
using CurrentSquares = std::array<double, 3>;

/// Of one stimulus; zero for one that presses on nothing. A pulse counts for its time at its
/// height.
CurrentSquares squares_of(const Protocol &protocol, const StudySetting &setting,
                          const Presented &one) {
    const PlacedCondition &place = setting.conditions[one.condition];
    CurrentSquares squares{};
    if (place.surface == nullptr || !place.problem.empty()) {
        return squares;
    }
    const std::optional<PredictedPress> press = predicted_press(setting, one, protocol.stimulus);
    if (!press) {
        return squares;
    }
    const double pulse_share =
        std::min(1.0, 1.0 / (one.parameters.pulse_hz * protocol.timing.presentation_s));
    const Vector3 full_A = currents_A(setting.device, press->q_rad, press->force_N);
    const Vector3 held_A = currents_A(setting.device, press->q_rad, press->held_N);
    for (std::size_t i = 0; i < squares.size(); ++i) {
        const auto motor = static_cast<Eigen::Index>(i);
        squares[i] = pulse_share * full_A[motor] * full_A[motor] +
                     (1.0 - pulse_share) * held_A[motor] * held_A[motor];
    }
    return squares;
}

/// A winding may be so much colder than the band before it is worth telling [K].
constexpr double kBelowBand_K = 2.0;

/// The session's rhythm: stimuli, and the time between them.
struct Rhythm {
    double loaded_s = 0.0; ///< of a trial
    double idle_s = 0.0;
    int every_trials = 0; ///< 0: no breaks
    double break_s = 0.0;
    double total_s = 0.0;
};

Rhythm rhythm_of(const Protocol &protocol, const SessionLength &length) {
    Rhythm rhythm;
    rhythm.loaded_s = presentations_per_trial(protocol) * protocol.timing.presentation_s;
    rhythm.idle_s = std::max(0.0, usual_trial_s(protocol) - rhythm.loaded_s);
    rhythm.every_trials = protocol.breaks.every_trials;
    rhythm.break_s = protocol.breaks.break_s;
    rhythm.total_s = std::min(length.max_s, 60.0 * protocol.stopping.longest_session_min);
    return rhythm;
}

struct Extremes {
    double lowest_C = 0.0; ///< at the ends of trials
    double highest_C = 0.0;
};

constexpr double kStep_s = 0.05;

/// Warm, when winding and housing have met.
device::WindingTemperature warmed(const device::MotorParameters &motor, const WindingBand &band,
                                  double current_A) {
    constexpr double kTimes = 3.0;
    device::WindingTemperature temperature =
        predicted_heating(motor, band, current_A, kStep_s).temperature;
    temperature.set_period(kTimes * motor.thermal.winding_time_s);
    temperature.update(0.0);
    temperature.set_period(kStep_s);
    return temperature;
}

/// A winding that is warm at the start and carries the current in every stimulus of a session.
class WarmWinding {
public:
    WarmWinding(const device::MotorParameters &motor, const device::WindingTemperature &warmed,
                double square_A2)
        : motor_(motor), temperature_(warmed), square_A2_(square_A2) {}

    Extremes over(const Rhythm &rhythm) {
        Extremes found{temperature_.winding_C(), temperature_.winding_C()};
        int trial = 0;
        double now_s = 0.0;
        while (now_s < rhythm.total_s) {
            pass(rhythm.loaded_s, square_A2_);
            found.highest_C = std::max(found.highest_C, temperature_.winding_C());
            pass(rhythm.idle_s, 0.0);
            if (rhythm.every_trials > 0 && ++trial % rhythm.every_trials == 0) {
                pass(rhythm.break_s, 0.0);
                now_s += rhythm.break_s;
            }
            now_s += rhythm.loaded_s + rhythm.idle_s;
            found.lowest_C = std::min(found.lowest_C, temperature_.winding_C());
        }
        return found;
    }

private:
    void pass(double seconds, double square_A2) {
        for (long i = std::lround(seconds / kStep_s); i > 0; --i) {
            temperature_.update(
                square_A2 * device::winding_resistance_Ohm(motor_, temperature_.winding_C(), 0.0));
        }
    }

    device::MotorParameters motor_;
    device::WindingTemperature temperature_;
    double square_A2_;
};

CurrentSquares mean_of(const std::vector<CurrentSquares> &all) {
    CurrentSquares mean{};
    for (const CurrentSquares &one : all) {
        for (std::size_t i = 0; i < mean.size(); ++i) {
            mean[i] += one[i] / static_cast<double>(all.size());
        }
    }
    return mean;
}

} // namespace

SessionWarmth check_warmth(const Protocol &protocol, const StudySetting &setting,
                           const std::vector<Presented> &presented, const SessionLength &length) {
    std::vector<CurrentSquares> all;
    all.reserve(presented.size());
    for (const Presented &one : presented) {
        all.push_back(squares_of(protocol, setting, one));
    }
    const CurrentSquares mean = mean_of(all);
    const Rhythm rhythm = rhythm_of(protocol, length);
    const WindingBand &band = protocol.windings;
    SessionWarmth warmth;
    warmth.hottest_C = band.from_C;
    double coldest_C = band.from_C;
    const Vector3 current_A = warming_current_A(setting, warming_place_m(protocol, setting));
    for (std::size_t i = 0; i < setting.device.motor.size(); ++i) {
        const device::MotorParameters &motor = setting.device.motor[i];
        double most_A2 = 0.0;
        for (const CurrentSquares &one : all) {
            most_A2 = std::max(most_A2, one[i]);
        }
        const device::WindingTemperature warm =
            warmed(motor, band, current_A[static_cast<Eigen::Index>(i)]);
        warmth.hottest_C =
            std::max(warmth.hottest_C, WarmWinding(motor, warm, most_A2).over(rhythm).highest_C);
        coldest_C = std::min(coldest_C, WarmWinding(motor, warm, mean[i]).over(rhythm).lowest_C);
    }
    const double max_C = setting.device.motor[0].thermal.max_winding_C;
    if (warmth.hottest_C >= max_C) {
        warmth.findings.push_back(
            {Severity::error, "windings",
             fmt::format("reach {:.0f} °C in a session of the stimulus that heats most; the limit "
                         "is {:g} °C",
                         warmth.hottest_C, max_C),
             "lower press_N or timing.presentation_s, or lengthen the pauses"});
    } else if (warmth.hottest_C > band.to_C) {
        warmth.findings.push_back(
            {Severity::warning, "windings",
             fmt::format("reach {:.0f} °C in a session of the stimulus that heats most; trials "
                         "wait above windings.to_C, {:g} °C",
                         warmth.hottest_C, band.to_C),
             "raise windings.to_C, lower press_N, or lengthen the pauses"});
    }
    if (coldest_C < band.from_C - kBelowBand_K) {
        warmth.findings.push_back(
            {Severity::note, "windings",
             fmt::format("cool to {:.0f} °C within a session of the mean stimulus, below the {:g} "
                         "°C to which they are warmed: they are warmed again before the next trial",
                         coldest_C, band.from_C),
             ""});
    }
    return warmth;
}

} // namespace springdrive::study

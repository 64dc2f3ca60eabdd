#include "base/degrees.h"
#include "base/vector.h"
#include "device/core/hand_parameters.h"
#include "device/core/motor/winding_heat.h"
#include "device/core/phantom/kinematics.h"
#include "engine/servo/command_limiter.h"
#include "engine/servo/safety_limits.h"
#include "engine/study/protocol/protocol_check.h"
#include "engine/study/protocol/stimulus_trial.h"
#include "engine/study/protocol/study_setting.h"

#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace springdrive::study {

namespace {

/// Deeper than this a hand does not feel where the surface is [m]: about a finger's width.
constexpr double kDeep_m = 0.015;

/// What a relaxed hand may be pushed aside without leaving the spot [m].
constexpr double kAside_m = 0.003;

using Findings = ProtocolFindings;

void check_force(Findings &findings, const std::string &where, const StudySetting &setting,
                 const PredictedPress &press) {
    const double limit_N = servo::kLimiterShare * setting.device.limits.tip_force_N;
    if (press.force_N.norm() > limit_N) {
        findings.push_back(
            {Severity::error, where,
             fmt::format("asks for {:.2f} N at the tip; the servo holds back from {:.2f} N on",
                         press.force_N.norm(), limit_N),
             "lower press_N, pulse_N, speed_m_per_s or the stiffness"});
    }
}

void check_motors(Findings &findings, const std::string &where, const StudySetting &setting,
                  const PredictedPress &press, double hot_C) {
    const Vector3 currents = currents_A(setting.device, press.q_rad, press.force_N);
    for (std::size_t i = 0; i < setting.device.motor.size(); ++i) {
        const device::MotorParameters &motor = setting.device.motor[i];
        const double current_A = std::abs(currents[static_cast<Eigen::Index>(i)]);
        const double limit_A = servo::kLimiterShare * motor.peak_current_A;
        if (current_A > limit_A) {
            findings.push_back({Severity::error, where,
                                fmt::format("asks for {:.2f} A in motor {}; the servo holds back "
                                            "from {:.2f} A on",
                                            current_A, i + 1, limit_A),
                                "lower press_N, pulse_N, speed_m_per_s or the stiffness"});
        }
        const double voltage_V = current_A * device::max_resistance_Ohm(motor, hot_C);
        if (voltage_V > motor.supply_V) {
            findings.push_back({Severity::error, where,
                                fmt::format("asks for {:.1f} V at motor {} with a winding of {:g} "
                                            "°C; the supply has {:g} V",
                                            voltage_V, i + 1, hot_C, motor.supply_V),
                                "lower press_N, pulse_N or speed_m_per_s, or windings.to_C"});
        }
    }
}

void check_energy(Findings &findings, const std::string &where, const Protocol &protocol,
                  const StudySetting &setting, const Condition &condition,
                  const PredictedPress &press) {
    const double limit_J = setting.device.limits.generated_energy_J;
    if (press.held_energy_J > limit_J) {
        findings.push_back(
            {Severity::error, where,
             fmt::format("holds {:.1f} mJ in its spring, {:.1f} mm deep; a change of stiffness may "
                         "give them back, and the limit of generated energy is {:.1f} mJ",
                         1e3 * press.held_energy_J, 1e3 * press.depth_m, 1e3 * limit_J),
             "lower press_N or speed_m_per_s, or make it stiffer"});
    }
    if (protocol.stimulus != StimulusForm::pulse) {
        return;
    }
    if (const double pulse_J = pulse_energy_J(setting.device, press, condition);
        pulse_J > limit_J) {
        findings.push_back(
            {Severity::error, where,
             fmt::format("its pulse may give {:.1f} mJ to a light hand; the limit of generated "
                         "energy is {:.1f} mJ",
                         1e3 * pulse_J, 1e3 * limit_J),
             "lower pulse_N or raise pulse_hz"});
    }
}

void check_depth(Findings &findings, const std::string &where, const StudySetting &setting,
                 const PlacedCondition &place, const PredictedPress &press) {
    const Vector3 deepest_m = place.spot.point_m - press.depth_m * place.spot.normal;
    if (!device::can_reach(setting.device, deepest_m)) {
        findings.push_back({Severity::error, where,
                            fmt::format("lets the hand {:.0f} mm deep, out of the device's reach",
                                        1e3 * press.depth_m),
                            "lower press_N, or make it stiffer"});
    } else if (press.depth_m > kDeep_m) {
        findings.push_back({Severity::warning, where,
                            fmt::format("lets the hand {:.0f} mm deep: it will be felt as a place, "
                                        "not as a surface",
                                        1e3 * press.depth_m),
                            "lower press_N, or make it stiffer"});
    }
}

/// On a surface without friction nothing but the hand itself holds the tip against a force that is
/// not square to it.
void check_slide(Findings &findings, const std::string &where, const PlacedCondition &place,
                 const Condition &condition, const PredictedPress &press) {
    if (condition.hold == Hold::cup) {
        return;
    }
    const Vector3 &n = place.spot.normal;
    const double aside_N = (press.force_N - press.force_N.dot(n) * n).norm();
    const double aside_m = aside_N / device::HandParameters{}.stiffness_N_per_m;
    if (aside_m > kAside_m) {
        findings.push_back(
            {Severity::error, where,
             fmt::format("pushes with {:.2f} N along the surface, so a relaxed hand slides {:.1f} "
                         "mm off the spot; at most {:g} mm",
                         aside_N, 1e3 * aside_m, 1e3 * kAside_m),
             "set hold = \"cup\", or lower press_N or turn_deg"});
    }
}

Findings findings_of_stimulus(const Protocol &protocol, const StudySetting &setting,
                              const Presented &one) {
    const PlacedCondition &place = setting.conditions[one.condition];
    const std::string where = name_of(protocol, one);
    const std::optional<PredictedPress> press = predicted_press(setting, one, protocol.stimulus);
    if (!press) {
        return {{Severity::error, where,
                 "gives the hand nothing to press on: it has no static stiffness",
                 "raise K_P_V_per_rad, or lower eta"}};
    }
    Findings findings;
    check_force(findings, where, setting, *press);
    check_motors(findings, where, setting, *press, protocol.windings.to_C);
    check_energy(findings, where, protocol, setting, one.parameters, *press);
    check_depth(findings, where, setting, place, *press);
    check_slide(findings, where, place, one.parameters, *press);
    return findings;
}

double angle_deg(const Vector3 &a, const Vector3 &b) {
    return kDegreesPerRadian * std::atan2(a.cross(b).norm(), a.dot(b));
}

double of_pulse_deg(const device::DeviceDescription &device, const Matrix3 &J,
                    const Condition &condition, const Vector3 &direction) {
    const Matrix3 to_tip = J.transpose().inverse();
    const double impulse_Ns = 0.5 * condition.pulse_N / condition.pulse_hz;
    double max_deg = 0.0;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const device::MotorParameters &motor = device.motor[static_cast<std::size_t>(j)];
        const double dR_Ohm = device::residual_resistance_Ohm(motor, condition.tuning.dR_Ohm);
        const double count_Nms = motor.torque_constant_Nm_per_A * motor.torque_constant_Nm_per_A *
                                 device.rad_per_count() / dR_Ohm;
        const Vector3 count_Ns = count_Nms * to_tip.col(j);
        const Vector3 across_Ns = count_Ns - count_Ns.dot(direction) * direction;
        max_deg = std::max(max_deg, kDegreesPerRadian * std::atan2(across_Ns.norm(), impulse_Ns));
    }
    return max_deg;
}

double of_press_deg(const device::DeviceDescription &device, const Vector3 &q_rad,
                    const Vector3 &force_N) {
    const auto J_at = [&](const Vector3 &at_rad) {
        return device::motor_jacobian(device.geometry, at_rad);
    };
    const Vector3 torque_Nm = J_at(q_rad).transpose() * force_N;
    double max_deg = 0.0;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const Vector3 count_rad = device.rad_per_count() * Vector3::Unit(j);
        const Vector3 turned_rad = q_rad + device::joint_from_motor(device.geometry, count_rad);
        max_deg = std::max(max_deg,
                           angle_deg(J_at(turned_rad).transpose().inverse() * torque_Nm, force_N));
    }
    return max_deg;
}

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

ProtocolFindings once_per_condition(const std::vector<StimulusFinding> &all) {
    ProtocolFindings told;
    std::vector<std::size_t> condition;
    std::vector<int> more;
    for (const StimulusFinding &one : all) {
        std::size_t i = 0;
        while (i < told.size() &&
               (condition[i] != one.condition || told[i].severity != one.finding.severity ||
                told[i].remedy != one.finding.remedy)) {
            ++i;
        }
        if (i == told.size()) {
            told.push_back(one.finding);
            condition.push_back(one.condition);
            more.push_back(0);
        } else {
            ++more[i];
        }
    }
    for (std::size_t i = 0; i < told.size(); ++i) {
        told[i].what += more[i] == 0 ? "" : fmt::format(" (so at {} further levels)", more[i]);
    }
    return told;
}

ProtocolFindings check_limits(const Protocol &protocol, const StudySetting &setting,
                              const std::vector<Presented> &presented) {
    std::vector<StimulusFinding> all;
    for (const Presented &one : presented) {
        const PlacedCondition &place = setting.conditions[one.condition];
        if (place.surface == nullptr || !place.problem.empty()) {
            continue;
        }
        for (ProtocolFinding &finding : findings_of_stimulus(protocol, setting, one)) {
            all.push_back({one.condition, std::move(finding)});
        }
    }
    return once_per_condition(all);
}

double count_angle_deg(const Protocol &protocol, const StudySetting &setting,
                       const Presented &presented) {
    const bool is_pulse = protocol.stimulus == StimulusForm::pulse;
    if (!is_pulse && protocol.stimulus != StimulusForm::press) {
        return 0.0;
    }
    const std::optional<PredictedPress> press =
        predicted_press(setting, presented, protocol.stimulus);
    if (!press) {
        return 0.0;
    }
    if (!is_pulse) {
        return of_press_deg(setting.device, press->q_rad, press->held_N);
    }
    const Stimulus stimulus = stimulus_of(protocol, setting, presented);
    return of_pulse_deg(setting.device,
                        device::motor_jacobian(setting.device.geometry, press->q_rad),
                        presented.parameters, stimulus.direction);
}

ProtocolFindings check_marking(const Protocol &protocol, const StudySetting &setting,
                               const std::vector<Presented> &presented) {
    std::vector<StimulusFinding> all;
    const double band_deg = protocol.marking.direction_deg;
    for (const Presented &one : presented) {
        const PlacedCondition &place = setting.conditions[one.condition];
        const bool is_told = place.surface != nullptr && place.problem.empty() &&
                             intended_measures(protocol, setting, one).turn_deg.has_value();
        const double count_deg = is_told ? count_angle_deg(protocol, setting, one) : 0.0;
        if (count_deg > band_deg) {
            all.push_back(
                {one.condition,
                 {Severity::warning, name_of(protocol, one),
                  fmt::format("has a band of {:g}° for its direction, of which one encoder count "
                              "is {:.2g}°: trials will be marked by chance",
                              band_deg, count_deg),
                  fmt::format("raise marking.direction_deg to {:.2g} or more, raise pulse_N, or "
                              "lower pulse_hz",
                              std::ceil(10.0 * count_deg) / 10.0)}});
        }
    }
    return once_per_condition(all);
}

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

#include "engine/study/protocol/condition_trial.h"

#include "base/parallel.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/rig/servo_rig.h"
#include "engine/study/protocol/predicted_press.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

namespace springdrive::study {

namespace {

constexpr double kStart_s = 1.2;    ///< the servo waits for rest, then raises its gains
constexpr double kApproach_s = 0.5; ///< to the spot
constexpr double kLongest_s = 1.0;  ///< of a presentation: what happens later happens by then
constexpr double kBack_s = 0.3;
constexpr double kLast_s = 0.1;           ///< of a press, in which the hand should be still
constexpr double kFollowThrough_m = 0.01; ///< of a blow

/// The hand's path, and when the stimulus is presented.
struct HandCourse {
    std::vector<simulated::HandPath::Point> points;
    double from_s = 0.0;
    double until_s = 0.0;
    bool is_held = false; ///< at its end the hand presses and is still
};

/// Down to where the hand's spring presses as hard as the condition asks.
HandCourse press_course(const Condition &condition, const scene::TouchSpot &spot,
                        const PredictedPress &press, double presentation_s) {
    const Vector3 above_m = spot.point_m + study::kApproach_m * spot.normal;
    const double K = press.stiffness_N_per_m;
    const double deep_m =
        condition.press_N * (1.0 / K + 1.0 / device::HandParameters{}.stiffness_N_per_m);
    constexpr double kSettle_s = 0.2;
    HandCourse course;
    course.from_s = kStart_s + kApproach_s + kSettle_s;
    course.until_s = course.from_s + presentation_s;
    course.is_held = true;
    course.points = {{0.0, above_m},
                     {kStart_s, above_m},
                     {kStart_s + kApproach_s, spot.point_m},
                     {course.from_s, spot.point_m - deep_m * spot.normal},
                     {course.until_s, spot.point_m - deep_m * spot.normal},
                     {course.until_s + kBack_s, above_m}};
    return course;
}

/// At constant speed through the surface.
HandCourse blow_course(const Condition &condition, const scene::TouchSpot &spot,
                       double presentation_s) {
    const Vector3 above_m = spot.point_m + study::kApproach_m * spot.normal;
    const Vector3 below_m = spot.point_m - kFollowThrough_m * spot.normal;
    HandCourse course;
    course.from_s = kStart_s;
    const double arrived_s =
        kStart_s + (study::kApproach_m + kFollowThrough_m) / condition.speed_m_per_s;
    course.until_s = arrived_s + std::min(presentation_s, 0.3);
    course.points = {{0.0, above_m},
                     {kStart_s, above_m},
                     {arrived_s, below_m},
                     {course.until_s, below_m},
                     {course.until_s + kBack_s, above_m}};
    return course;
}

/// To and fro along a sine with the condition's speed at most.
HandCourse stroke_course(const Condition &condition, const scene::TouchSpot &spot,
                         double presentation_s) {
    const double omega = condition.speed_m_per_s / kStroke_m;
    constexpr double kStep_s = 0.01;
    HandCourse course;
    course.from_s = kStart_s;
    course.until_s = kStart_s + std::max(presentation_s, std::numbers::pi / omega);
    course.points = {{0.0, spot.point_m}};
    for (double now_s = kStart_s; now_s < course.until_s; now_s += kStep_s) {
        course.points.push_back(
            {now_s,
             spot.point_m + kStroke_m * std::sin(omega * (now_s - kStart_s)) * Vector3::UnitX()});
    }
    return course;
}

HandCourse course_of(const Protocol &protocol, const Condition &condition,
                     const scene::TouchSpot &spot, const std::optional<PredictedPress> &press) {
    const double presentation_s = std::min(protocol.timing.presentation_s, kLongest_s);
    switch (protocol.stimulus) {
    case StimulusForm::blow:
        return blow_course(condition, spot, presentation_s);
    case StimulusForm::stroke:
        return stroke_course(condition, spot, presentation_s);
    case StimulusForm::press:
    case StimulusForm::pulse:
        break;
    }
    return press_course(condition, spot, press.value_or(PredictedPress{}), presentation_s);
}

class TrialRun {
public:
    TrialRun(const Protocol &protocol, const StudySetting &setting, const Presented &presented)
        : protocol_(protocol), device_(setting.device), presented_(presented),
          condition_(presented.parameters), place_(setting.conditions[presented.condition]),
          global_alpha_rad2_per_m2_(setting.global_alpha_rad2_per_m2),
          press_(predicted_press(setting, presented, protocol.stimulus)),
          course_(course_of(protocol, condition_, place_.spot, press_)) {
        seen_.name = name_of(protocol, presented);
        seen_.is_turned = condition_.turn_deg == 0.0 || protocol.stimulus == StimulusForm::pulse;
    }

    ConditionTrial run() {
        simulated::SimulationOptions options;
        options.servo_period_s = 1.0 / condition_.servo_hz;
        options.delay_periods = condition_.delay_periods;
        options.path.emplace(course_.points);
        rig::ServoRig rig(device_, options, course_.points.front().position_m,
                          place_.surface.get());
        rig.inputs.tuning = presented_.free_space;
        rig.inputs.global_alpha_rad2_per_m2 = global_alpha_rad2_per_m2_;
        const auto ticks = std::lround(course_.points.back().time_s * condition_.servo_hz);
        for (long tick = 0; tick < ticks && seen_.trip.empty(); ++tick) {
            rig.inputs.excitation_V = pulse_V(rig.last.time_s);
            note(rig.tick(), rig);
        }
        return seen_;
    }

private:
    [[nodiscard]] Vector3 pulse_V(double now_s) const {
        const double since_s = now_s - course_.from_s;
        if (protocol_.stimulus != StimulusForm::pulse || !press_ || since_s < 0.0 ||
            since_s * condition_.pulse_hz > 1.0) {
            return Vector3::Zero();
        }
        const double share =
            0.5 * (1.0 - std::cos(2.0 * std::numbers::pi * condition_.pulse_hz * since_s));
        const Vector3 force_N = condition_.pulse_N * share * turned(condition_, place_.spot.normal);
        // e_W that lets the motors push with that force at rest.
        return condition_.tuning.dR_Ohm * currents_A(device_, press_->q_rad, force_N);
    }

    void note(const servo::ServoSample &sample, rig::ServoRig &rig) {
        if (rig.has_tripped()) {
            seen_.trip = servo::description(sample.safety);
        }
        seen_.largest_force_N = std::max(seen_.largest_force_N, sample.tip_force_N.norm());
        seen_.generated_J = std::max(seen_.generated_J, sample.generated_energy_J);
        seen_.is_held_back =
            seen_.is_held_back || sample.held_back.holds_force() || sample.held_back.voltage;
        const bool touches = sample.contact.touching;
        if (touches && !touched_m_) {
            touched_m_ = sample.tip_m;
            seen_.has_touched = true;
            if (condition_.hold == Hold::cup) {
                rig.inputs.fixed_x0_m = sample.contact.x0_m;
            }
        }
        if (sample.time_s > course_.until_s) {
            rig.inputs.fixed_x0_m.reset();
        }
        rig.inputs.tuning = touches ? condition_.tuning : presented_.free_space;
        if (touched_m_ && touches && sample.time_s <= course_.until_s) {
            const Vector3 moved_m = sample.tip_m - *touched_m_;
            const Vector3 &n = place_.spot.normal;
            seen_.slid_m = std::max(seen_.slid_m, (moved_m - moved_m.dot(n) * n).norm());
            if (sample.time_s > course_.until_s - kLast_s && course_.is_held) {
                seen_.shaking_m_per_s =
                    std::max(seen_.shaking_m_per_s, rig.truth().tip_velocity_m_per_s.norm());
            }
            seen_.deepest_m = std::max(seen_.deepest_m, n.dot(place_.spot.point_m - sample.tip_m));
        }
    }

    const Protocol &protocol_;
    const device::DeviceDescription &device_;
    const Presented &presented_;
    const Condition &condition_;
    const PlacedCondition &place_;
    double global_alpha_rad2_per_m2_;
    std::optional<PredictedPress> press_;
    HandCourse course_;
    std::optional<Vector3> touched_m_;
    ConditionTrial seen_;
};

} // namespace

ConditionTrial try_condition(const Protocol &protocol, const StudySetting &setting,
                             const Presented &presented) {
    return TrialRun(protocol, setting, presented).run();
}

std::vector<ConditionTrial> try_conditions(const Protocol &protocol, const StudySetting &setting,
                                           const std::vector<Presented> &presented) {
    std::vector<ConditionTrial> trials(presented.size());
    for_each_in_parallel(presented.size(), all_processors(), [&](std::size_t i) {
        trials[i] = try_condition(protocol, setting, presented[i]);
    });
    return trials;
}

ProtocolFindings findings_of(const Protocol &protocol, const std::vector<ConditionTrial> &trials) {
    ProtocolFindings findings;
    bool all_turned = true;
    for (const ConditionTrial &trial : trials) {
        all_turned = all_turned && trial.is_turned;
        if (!trial.trip.empty()) {
            findings.push_back({Severity::error, trial.name,
                                "the safety monitor trips in simulation: " + trial.trip,
                                "make the stimulus weaker, or softer"});
            continue;
        }
        if (protocol.stimulus != StimulusForm::stroke && !trial.has_touched) {
            findings.push_back({Severity::error, trial.name,
                                "the simulated hand never touches the surface",
                                "move the spot, or turn its normal out of the surface"});
        }
        if (trial.slid_m > kMostSlide_m) {
            findings.push_back({Severity::error, trial.name,
                                fmt::format("a simulated hand slides {:.1f} mm off the spot; at "
                                            "most {:g} mm",
                                            1e3 * trial.slid_m, 1e3 * kMostSlide_m),
                                "choose a flatter spot, press less, or set hold = \"cup\""});
        }
        if (trial.shaking_m_per_s > kMostShaking_m_per_s) {
            findings.push_back(
                {Severity::error, trial.name,
                 fmt::format("the tip shakes with {:.0f} mm/s while a simulated "
                             "hand holds still; at most {:g} mm/s",
                             1e3 * trial.shaking_m_per_s, 1e3 * kMostShaking_m_per_s),
                 "lower K_P_V_per_rad or K_D_Vs_per_rad"});
        }
        if (trial.is_held_back) {
            findings.push_back({Severity::warning, trial.name,
                                fmt::format("the servo holds its force back in simulation; the "
                                            "largest is {:.2f} N",
                                            trial.largest_force_N),
                                "make the stimulus weaker, or it is not what it says"});
        }
    }
    if (!all_turned) {
        findings.push_back({Severity::note, "simulation",
                            "presses and blows were simulated with the force along the normal: the "
                            "control law cannot turn it yet",
                            ""});
    }
    return findings;
}

} // namespace springdrive::study

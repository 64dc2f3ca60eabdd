#include "engine/study/protocol/stimulus_trial.h"

#include "device/core/hand_parameters.h"
#include "device/core/phantom/dynamics.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/rig/servo_rig.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace springdrive::study {

namespace {

constexpr double kDown_s = 0.5; ///< from the start to the touch
constexpr double kTouch_m =
    0.001;                        ///< deep: until there it does not know how far it will have to go
constexpr double kSettle_s = 0.2; ///< from there to the press
constexpr double kBack_s = 0.3;
constexpr double kLater_s = 0.05;         ///< so much longer, to be sure that it is over
constexpr double kFollowThrough_m = 0.01; ///< of a blow

/// What holds the linkage against its weight, at the tip [N].
Vector3 holding_N(const device::DeviceDescription &device, const Vector3 &q_rad) {
    const Vector3 weight_Nm = device::gravity_torque_Nm(
        device::linkage_moments(device.geometry, device.inertia, 0.0), q_rad);
    return device::joint_jacobian(device.geometry, q_rad).transpose().inverse() * weight_Nm;
}

/// Down to where the hand's spring presses as hard as the condition asks.
HandTrajectory press_trajectory(const StudySetting &setting, const Presented &presented,
                                const Stimulus &stimulus, const HandDeviation &hand) {
    const scene::TouchSpot &spot = setting.conditions[presented.condition].spot;
    const PredictedPress press =
        predicted_press(setting, presented, stimulus.form).value_or(PredictedPress{});
    const double press_N = hand.share * presented.parameters.press_N;
    const double K_hand = device::HandParameters{}.stiffness_N_per_m;
    const double deep_m =
        press_N / press.stiffness_N_per_m +
        (press_N - spot.normal.dot(holding_N(setting.device, press.q_rad))) / K_hand;
    const Vector3 above_m = stimulus.start_m + hand.aside_m;
    const Vector3 at_m = spot.point_m + hand.aside_m;
    const Vector3 pressing_m = at_m - deep_m * spot.normal;
    const Vector3 touching_m = at_m - std::min(deep_m, kTouch_m) * spot.normal;
    const double start_s = kServoStart_s + stimulus.rest_s;
    HandTrajectory trajectory;
    trajectory.from_s = start_s + kDown_s + kSettle_s;
    trajectory.until_s =
        trajectory.from_s + stimulus.presentation_s + kLater_s + glide_back_s(stimulus);
    trajectory.is_held = true;
    trajectory.points = {{0.0, above_m},
                         {start_s, above_m},
                         {start_s + kDown_s, touching_m},
                         {trajectory.from_s, pressing_m},
                         {trajectory.until_s, pressing_m},
                         {trajectory.until_s + kBack_s, above_m}};
    return trajectory;
}

/// At constant speed through the surface.
HandTrajectory blow_trajectory(const StudySetting &setting, const Presented &presented,
                               const Stimulus &stimulus, const HandDeviation &hand) {
    const scene::TouchSpot &spot = setting.conditions[presented.condition].spot;
    const Vector3 above_m = stimulus.start_m + hand.aside_m;
    const Vector3 below_m = spot.point_m + hand.aside_m - kFollowThrough_m * spot.normal;
    HandTrajectory trajectory;
    trajectory.from_s = kServoStart_s + stimulus.rest_s;
    const double arrived_s =
        trajectory.from_s +
        (kApproach_m + kFollowThrough_m) / (hand.share * presented.parameters.speed_m_per_s);
    trajectory.until_s = arrived_s + stimulus.presentation_s + kLater_s + glide_back_s(stimulus);
    trajectory.points = {{0.0, above_m},
                         {trajectory.from_s, above_m},
                         {arrived_s, below_m},
                         {trajectory.until_s, below_m},
                         {trajectory.until_s + kBack_s, above_m}};
    return trajectory;
}

/// To and fro along a sine with that speed at most, which it reaches softly.
std::vector<simulated::HandPath::Point> stroke_points(const Vector3 &about_m, double from_s,
                                                      double duration_s, double speed_m_per_s) {
    constexpr double kCorner_s = 0.01; // from one corner of the polyline to the next
    constexpr double kSoftly_s = 0.2;
    const double omega = speed_m_per_s / kStroke_m;
    std::vector<simulated::HandPath::Point> points;
    double since_s = 0.0;
    while (since_s < duration_s) {
        const double way_m =
            kStroke_m * -std::expm1(-since_s / kSoftly_s) * std::sin(omega * since_s);
        points.push_back({from_s + since_s, about_m + way_m * Vector3::UnitX()});
        since_s += kCorner_s;
    }
    return points;
}

HandTrajectory stroke_trajectory(const Presented &presented, const Stimulus &stimulus,
                                 const HandDeviation &hand) {
    HandTrajectory trajectory;
    trajectory.from_s = kServoStart_s + stimulus.rest_s;
    trajectory.until_s = trajectory.from_s + stimulus.presentation_s + kLater_s;
    trajectory.points =
        stroke_points(stimulus.start_m, trajectory.from_s, trajectory.until_s - trajectory.from_s,
                      hand.share * presented.parameters.speed_m_per_s);
    trajectory.points.insert(trajectory.points.begin(), {0.0, stimulus.start_m});
    return trajectory;
}

constexpr double kLast_s = 0.1; ///< of a press, in which the hand should be still

/// What tells all of it.
double long_enough_s(const Stimulus &stimulus, const Condition &condition) {
    switch (stimulus.form) {
    case StimulusForm::press:
        return 1.0;
    case StimulusForm::blow:
        return 0.3;
    case StimulusForm::pulse:
        return 0.5 + std::max(0.5, stimulus.pulse.length_s() + kAfterPulse_s);
    case StimulusForm::stroke:
        break;
    }
    return std::max(1.0, std::numbers::pi * kStroke_m / condition.speed_m_per_s);
}

Stimulus cut(Stimulus stimulus, const Condition &condition) {
    stimulus.presentation_s = std::min(stimulus.presentation_s, long_enough_s(stimulus, condition));
    return stimulus;
}

constexpr double kCoolingStep_s = 0.25; ///< at which four terms of the exponential are exact
constexpr double kPredictionStep_s = 0.02;
constexpr double kUntilItRuns_s = 1.25; ///< at rest, then the gains are raised
constexpr double kMaxStep_s = 250e-6;   ///< 16 of a period of 250 Hz

MotorTemperatures rates_K_per_s(const device::DeviceDescription &device, double air_C,
                                const MotorTemperatures &now) {
    MotorTemperatures rates;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const device::ThermalParameters &thermal =
            device.motor[static_cast<std::size_t>(j)].thermal;
        const double outward_W =
            (now.winding_C[j] - now.housing_C[j]) / thermal.winding_housing_K_per_W;
        const double lost_W = (now.housing_C[j] - air_C) / thermal.housing_ambient_K_per_W;
        rates.winding_C[j] = -outward_W * thermal.winding_housing_K_per_W / thermal.winding_time_s;
        rates.housing_C[j] =
            (outward_W - lost_W) * thermal.housing_ambient_K_per_W / thermal.motor_time_s;
    }
    return rates;
}

MotorTemperatures sum(const MotorTemperatures &a, const MotorTemperatures &b, double share) {
    return {a.winding_C + share * b.winding_C, a.housing_C + share * b.housing_C};
}

} // namespace

HandTrajectory hand_trajectory(const StudySetting &setting, const Presented &presented,
                               const Stimulus &stimulus, const HandDeviation &hand) {
    switch (stimulus.form) {
    case StimulusForm::blow:
        return blow_trajectory(setting, presented, stimulus, hand);
    case StimulusForm::stroke:
        return stroke_trajectory(presented, stimulus, hand);
    case StimulusForm::press:
    case StimulusForm::pulse:
        break;
    }
    return press_trajectory(setting, presented, stimulus, hand);
}

StimulusTrial try_stimulus(const Protocol &protocol, const StudySetting &setting,
                           const Presented &presented, const StimulusCircumstances &circumstances) {
    const Condition &condition = presented.parameters;
    StimulusTrial seen;
    seen.name = name_of(protocol, presented);
    seen.stimulus = cut(stimulus_of(protocol, setting, presented), condition);
    HandTrajectory trajectory =
        hand_trajectory(setting, presented, seen.stimulus, circumstances.hand);
    if (circumstances.strokes_after_s > 0.0) {
        const simulated::HandPath::Point last = trajectory.points.back();
        const std::vector<simulated::HandPath::Point> strokes =
            stroke_points(last.position_m, last.time_s + 0.5, circumstances.strokes_after_s,
                          condition.speed_m_per_s);
        trajectory.points.insert(trajectory.points.end(), strokes.begin(), strokes.end());
    }

    simulated::SimulationOptions options;
    options.servo_period_s = 1.0 / condition.servo_hz;
    options.delay_periods = condition.delay_periods;
    options.path.emplace(trajectory.points);
    options.ambient_C = circumstances.winding_C.value_or(protocol.windings.from_C);
    options.device_seed = circumstances.device_seed;
    rig::ServoRig rig(setting.device, options, trajectory.points.front().position_m,
                      setting.conditions[presented.condition].surface.get());
    rig.inputs.tuning = presented.free_space;
    rig.inputs.global_alpha_rad2_per_m2 = setting.global_alpha_rad2_per_m2;
    rig.inputs.observes_resistance = true;

    StimulusRun run(setting.device, seen.stimulus, options.servo_period_s);
    DeliveryMeter meter(setting.device, seen.stimulus, options.servo_period_s);
    const auto ticks = std::lround(trajectory.points.back().time_s * condition.servo_hz);
    for (long tick = 0; tick < ticks && run.phase() != StimulusPhase::failed; ++tick) {
        const servo::ServoSample &sample = rig.tick();
        run.update(sample, rig.inputs);
        meter.take(sample, run);
        seen.has_touched = seen.has_touched || sample.contact.touching;
        const double left_s = seen.stimulus.presentation_s - run.presented_s();
        if (trajectory.is_held && run.phase() == StimulusPhase::presenting && left_s < kLast_s) {
            seen.shaking_m_per_s =
                std::max(seen.shaking_m_per_s, rig.truth().tip_velocity_m_per_s.norm());
        }
        if (circumstances.watch) {
            circumstances.watch(sample, run.phase());
        }
    }
    // Windings and housings were as warm as the air.
    seen.duration_s = rig.last.time_s;
    seen.winding_rise_K = rig.truth().winding_C - Vector3::Constant(options.ambient_C);
    seen.housing_rise_K = rig.truth().housing_C - Vector3::Constant(options.ambient_C);
    seen.delivered = meter.delivered();
    seen.failure = run.failure();
    if (rig.has_tripped()) {
        seen.trip = servo::description(rig.last.safety);
    }
    return seen;
}

Vector3 warming_place_m(const Protocol &protocol, const StudySetting &setting) {
    for (std::size_t i = 0; i < protocol.conditions.size(); ++i) {
        const PlacedCondition &place = setting.conditions[i];
        const Vector3 start_m = protocol.stimulus == StimulusForm::stroke
                                    ? place.spot.point_m
                                    : Vector3(place.spot.point_m + kApproach_m * place.spot.normal);
        if (is_used(protocol, i) && place.problem.empty() &&
            device::can_reach(setting.device, start_m)) {
            return start_m;
        }
    }
    return setting.device.workspace.centre_m;
}

Vector3 warming_current_A(const StudySetting &setting, const Vector3 &place_m) {
    const device::PhantomGeometry &geometry = setting.device.geometry;
    const Vector3 q_rad =
        device::joint_angles_rad(geometry, place_m).value_or(device::default_pose_rad());
    return warming_current_A(setting.device, servo::limits_of(setting.device),
                             device::motor_from_joint(geometry, q_rad));
}

double predicted_warm_up_s(const Protocol &protocol, const StudySetting &setting) {
    const Vector3 current_A = warming_current_A(setting, warming_place_m(protocol, setting));
    double longest_s = 0.0;
    for (Eigen::Index j = 0; j < 3; ++j) {
        longest_s = std::max(longest_s,
                             predicted_heating(setting.device.motor[static_cast<std::size_t>(j)],
                                               protocol.windings, current_A[j], kPredictionStep_s)
                                 .duration_s);
    }
    const double all_s = longest_s + 2.0 * WarmUp::kRamp_s;
    return all_s < WarmUp::kMax_s ? all_s : std::numeric_limits<double>::infinity();
}

MotorTemperatures cooled(const device::DeviceDescription &device, double air_C,
                         const MotorTemperatures &before, double seconds) {
    MotorTemperatures now = before;
    double left_s = seconds;
    while (left_s > 0.0) {
        const double h = std::min(left_s, kCoolingStep_s);
        MotorTemperatures gained = rates_K_per_s(device, air_C, now);
        for (const double share : {h / 4.0, h / 3.0, h / 2.0}) {
            gained = rates_K_per_s(device, air_C, sum(now, gained, share));
        }
        now = sum(now, gained, h);
        left_s -= kCoolingStep_s;
    }
    return now;
}

WarmUpTrial try_warm_up(const Protocol &protocol, const StudySetting &setting,
                        const MotorTemperatures &before) {
    const double coldest_C = std::min(before.winding_C.minCoeff(), before.housing_C.minCoeff());
    simulated::SimulationOptions options;
    options.servo_period_s = 1.0 / protocol.conditions.front().servo_hz;
    options.delay_periods = protocol.conditions.front().delay_periods;
    options.longest_step_s = std::min(kMaxStep_s, options.servo_period_s);
    options.ambient_C = coldest_C;
    rig::ServoRig rig(setting.device, options, warming_place_m(protocol, setting));
    rig.inputs.tuning = free_space_tuning(protocol, protocol.conditions.front())
                            .value_or(protocol.conditions.front().tuning);
    rig.inputs.observes_resistance = true;
    rig.run(kUntilItRuns_s);

    WarmUp warm_up(setting.device, protocol.windings, options.servo_period_s);
    WarmUpTrial seen;
    const Vector3 at_rest_N = rig.truth().hand_force_N;
    const double begun_s = rig.last.time_s;
    MotorTemperatures left = before; // of what they were, without the heat of now
    const double unheated_C = 0.5 * (device::kColdestAir_C + device::kWarmestAir_C);
    while (!warm_up.is_over()) {
        servo::ServoSample sample = rig.tick();
        left = cooled(setting.device, protocol.windings.air_C, left, options.servo_period_s);
        for (Eigen::Index j = 0; j < 3; ++j) {
            servo::WindingStatus &winding = sample.winding[static_cast<std::size_t>(j)];
            winding.min_C += left.winding_C[j] - unheated_C;
            winding.max_C += left.winding_C[j] - unheated_C;
        }
        warm_up.update(sample, rig.inputs);
        seen.hand_force_N =
            std::max(seen.hand_force_N, (rig.truth().hand_force_N - at_rest_N).norm());
    }
    seen.duration_s = rig.last.time_s - begun_s;
    seen.failure = warm_up.failure();
    if (rig.has_tripped()) {
        seen.trip = servo::description(rig.last.safety);
    }
    const Vector3 start_C = Vector3::Constant(coldest_C);
    seen.after = {left.winding_C + rig.truth().winding_C - start_C,
                  left.housing_C + rig.truth().housing_C - start_C};
    return seen;
}

} // namespace springdrive::study

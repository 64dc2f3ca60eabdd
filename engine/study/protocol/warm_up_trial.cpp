#include "engine/study/protocol/warm_up_trial.h"

#include "device/core/phantom/kinematics.h"
#include "engine/lab/rig/servo_rig.h"
#include "engine/study/protocol/presented.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace springdrive::study {

namespace {

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
    Vector3 min_m = rig.truth().tip_m;
    Vector3 max_m = min_m;
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
        seen.estimated_C = estimated_windings_C(sample);
        min_m = min_m.cwiseMin(rig.truth().tip_m);
        max_m = max_m.cwiseMax(rig.truth().tip_m);
        seen.hand_force_N =
            std::max(seen.hand_force_N, (rig.truth().hand_force_N - at_rest_N).norm());
    }
    seen.duration_s = rig.last.time_s - begun_s;
    seen.tip_way_m = (max_m - min_m).norm();
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

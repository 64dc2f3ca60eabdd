#include "engine/study/protocol/predicted_press.h"

#include "device/core/hand_parameters.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/lab/loops/both_maps.h"
#include "engine/lab/loops/stability_case.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace springdrive::study {

namespace {

double active_alpha(const StudySetting &setting, const control::Tuning &tuning, const Matrix3 &J) {
    switch (tuning.alpha_mode) {
    case control::AlphaMode::global:
        return setting.global_alpha_rad2_per_m2;
    case control::AlphaMode::by_hand:
        return tuning.alpha_rad2_per_m2;
    case control::AlphaMode::on_the_fly:
        break;
    }
    return control::alpha_bound(J, control::relative_stiffness(setting.device));
}

/// The static stiffness of the tip under the condition's map.
std::optional<Matrix3> static_stiffness(const StudySetting &setting, const Presented &presented,
                                        const Vector3 &q_rad, const Matrix3 &J) {
    const Condition &condition = presented.parameters;
    control::Tuning tuning = condition.tuning;
    const double surface_eta =
        condition.hold == Hold::cup ? 0.0 : setting.conditions[presented.condition].surface_eta;
    tuning.eta = control::combined_eta(surface_eta, tuning.eta);
    const std::optional<loops::MapStiffness> both =
        loops::map_stiffness(setting.device, tuning, q_rad, active_alpha(setting, tuning, J));
    if (!both) {
        return std::nullopt;
    }
    return tuning.map == control::MotionMap::inverse
               ? both->inverse_N_per_m
               : Matrix3(both->transpose_N_per_m * Matrix3::Identity());
}

/// The part of the hand's force along the normal, without a pulse.
double pressed_N(const device::DeviceDescription &device, const Condition &condition,
                 StimulusForm form, const PredictedPress &press, const Vector3 &normal) {
    if (form != StimulusForm::blow) {
        return condition.press_N;
    }
    const double mass_kg =
        device::HandParameters{}.mass_kg + tip_mass_kg(device, press.q_rad, normal);
    return condition.speed_m_per_s * std::sqrt(press.stiffness_N_per_m * mass_kg);
}

/// Sets depth, forces and energy of a press against the stiffness K.
void set_force(PredictedPress &press, const Condition &condition, StimulusForm form,
               const Matrix3 &K, const Vector3 &normal, double normal_N) {
    const Vector3 turn = turned(condition, normal);
    const bool is_turned = condition.turn_deg != 0.0 && form != StimulusForm::pulse;
    // Cut at 84 degrees, where the force would be ten times the press.
    const double against_hand = is_turned ? std::max(0.1, turn.dot(normal)) : 1.0;
    press.depth_m = normal_N / (press.stiffness_N_per_m * against_hand);
    const Vector3 straight_N = press.depth_m * (K * normal);
    press.held_N = is_turned ? Vector3(straight_N.dot(normal) * turn) : straight_N;
    press.force_N = press.held_N;
    if (form == StimulusForm::pulse) {
        press.force_N += condition.pulse_N * turn;
    }
    press.held_energy_J = 0.5 * press.depth_m * straight_N.dot(normal);
}

} // namespace

double tip_mass_kg(const device::DeviceDescription &device, const Vector3 &q_rad,
                   const Vector3 &direction) {
    loops::StabilityCase which;
    which.device = device;
    which.q_rad = q_rad;
    which.freedom = loops::Freedom::three_motors;
    const Matrix3 M = loops::driven_load(which, {0, loops::no_hand()}).inertia_kg_m2;
    const Matrix3 J = device::motor_jacobian(device.geometry, q_rad);
    return 1.0 / direction.dot(J * M.inverse() * J.transpose() * direction);
}

std::optional<PredictedPress> predicted_press(const StudySetting &setting,
                                              const Presented &presented, StimulusForm form) {
    const device::DeviceDescription &device = setting.device;
    const Condition &condition = presented.parameters;
    const scene::TouchSpot &spot = setting.conditions[presented.condition].spot;
    const std::optional<Vector3> q_rad = device::joint_angles_rad(device.geometry, spot.point_m);
    if (!q_rad || form == StimulusForm::stroke) {
        return std::nullopt;
    }
    PredictedPress press;
    press.q_rad = *q_rad;
    const Matrix3 J = device::motor_jacobian(device.geometry, *q_rad);
    const std::optional<Matrix3> K = static_stiffness(setting, presented, *q_rad, J);
    if (!K || !(spot.normal.dot(*K * spot.normal) > 0.0)) {
        return std::nullopt;
    }
    press.stiffness_N_per_m = spot.normal.dot(*K * spot.normal);
    set_force(press, condition, form, *K, spot.normal,
              pressed_N(device, condition, form, press, spot.normal));
    return press;
}

Vector3 currents_A(const device::DeviceDescription &device, const Vector3 &q_rad,
                   const Vector3 &force_N) {
    const Matrix3 J = device::motor_jacobian(device.geometry, q_rad);
    return (J.transpose() * force_N).cwiseQuotient(control::torque_constants(device));
}

double pulse_energy_J(const device::DeviceDescription &device, const PredictedPress &press,
                      const Condition &condition) {
    const loops::Hand light = loops::hand_of_firmness(0.0);
    const Vector3 pushed_N = press.force_N - press.held_N;
    const double mass_kg = light.mass_kg + tip_mass_kg(device, press.q_rad, pushed_N.normalized());
    const double impulse_Ns = 0.5 * condition.pulse_N / condition.pulse_hz; // of (1 − cos)/2
    return std::min(0.5 * impulse_Ns * impulse_Ns / mass_kg,
                    0.5 * condition.pulse_N * condition.pulse_N / light.stiffness_N_per_m);
}

} // namespace springdrive::study
